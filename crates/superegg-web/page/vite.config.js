import { defineConfig } from 'vite';

export default defineConfig({
  // The page works in any folder of a server.
  base: './',
  worker: { format: 'es' },
  build: {
    target: 'es2022',
    assetsInlineLimit: 0,
    rollupOptions: { input: ['index.html', 'embed.html', 'three.html'] },
  },
});
