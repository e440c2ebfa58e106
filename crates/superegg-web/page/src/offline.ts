// The page works without a network once it has been loaded.

/** Keeps what the page has loaded, where the browser can. */
export function keepOffline(): void {
  if (!import.meta.env.PROD || !('serviceWorker' in navigator)) return;
  const addresses = () => {
    const loaded = performance.getEntriesByType('resource').map((entry) => entry.name);
    return [location.href.split(/[?#]/)[0], ...loaded];
  };
  void navigator.serviceWorker
    .register('./sw.js')
    .then(() => navigator.serviceWorker.ready)
    .then((ready) => ready.active?.postMessage(addresses()))
    .catch(() => undefined);
}
