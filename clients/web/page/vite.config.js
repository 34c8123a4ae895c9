// How the page is bundled: one folder of static files that haptic-web serves from its root.
import { defineConfig } from 'vite';

export default defineConfig({
  base: './', // the gateway may stand behind a proxy, in a folder
  build: {
    outDir: process.env.HAPTICD_PAGE_OUT ?? 'dist',
    emptyOutDir: true,
    target: 'es2022',
    chunkSizeWarningLimit: 1500, // three.js alone is 700 kB; it comes from the next room
  },
});
