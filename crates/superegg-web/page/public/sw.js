// The page without a network: what was loaded once is kept, and used where the network fails.

const CACHE = 'superegg-1';

self.addEventListener('install', () => self.skipWaiting());
self.addEventListener('activate', (event) => event.waitUntil(self.clients.claim()));

// The page sends the addresses of what it loaded before this worker began.
self.addEventListener('message', (event) => {
  if (!Array.isArray(event.data)) return;
  const own = event.data.filter((address) => new URL(address).origin === self.location.origin);
  event.waitUntil(caches.open(CACHE).then((cache) => Promise.allSettled(own.map((address) => cache.add(address)))));
});

self.addEventListener('fetch', (event) => {
  const { request } = event;
  if (request.method !== 'GET' || new URL(request.url).origin !== self.location.origin) return;
  event.respondWith(respond(request));
});

async function respond(request) {
  const cache = await caches.open(CACHE);
  // Names with a hash never change.
  const isFixed = new URL(request.url).pathname.includes('/assets/');
  const kept = await cache.match(request, { ignoreSearch: true });
  if (isFixed && kept) return kept;
  try {
    const response = await fetch(request);
    if (response.ok) await cache.put(request, response.clone());
    return response;
  } catch (error) {
    if (kept) return kept;
    throw error;
  }
}
