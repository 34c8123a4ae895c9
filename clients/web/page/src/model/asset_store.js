// Files of a scene by their hash, fetched once: GET /asset/HASH of the gateway. What cannot be had is null and counted, and the caller
// draws something coarser.

export class AssetStore {
  #files = new Map();

  constructor(fetchFile = (hash) => fetch(`asset/${hash}`)) {
    this.fetchFile = fetchFile;
    this.missing = 0;
  }

  /** Bytes of `asset` {hash, size}, read by `read`; null where there is none, or it is damaged. */
  get(asset, read) {
    if (!asset) return Promise.resolve(null);
    if (!this.#files.has(asset.hash)) this.#files.set(asset.hash, this.#load(asset, read));
    return this.#files.get(asset.hash);
  }

  async #load(asset, read) {
    try {
      const answer = await this.fetchFile(asset.hash);
      if (!answer.ok) throw new Error(`the gateway has no asset ${asset.hash}`);
      const bytes = new Uint8Array(await answer.arrayBuffer());
      if (asset.size && bytes.length !== asset.size) throw new Error(`asset ${asset.hash} is damaged`);
      return read(bytes);
    } catch (error) {
      ++this.missing;
      this.#files.delete(asset.hash); // the next scene may ask again
      console.warn(String(error));
      return null;
    }
  }
}
