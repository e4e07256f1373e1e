/** A cache of things that take a fetch: the latest used ones, one fetch at a time for each. */
export class Kept<T extends { dispose(): void }> {
  private readonly most: number;
  private readonly fetch: (key: string) => Promise<T>;
  private readonly kept = new Map<string, Promise<T>>();

  constructor(most: number, fetch: (key: string) => Promise<T>) {
    this.most = most;
    this.fetch = fetch;
  }

  get(key: string): Promise<T> {
    const known = this.kept.get(key);
    const thing = known ?? this.fetch(key);
    this.kept.delete(key); // to the end: the map's order is that of use
    this.kept.set(key, thing);
    if (!known) {
      thing.catch(() => this.kept.delete(key)); // another look may succeed
      this.forgetOldest();
    }
    return thing;
  }

  dispose(): void {
    for (const thing of this.kept.values()) void thing.then((t) => t.dispose()).catch(() => {});
    this.kept.clear();
  }

  private forgetOldest(): void {
    for (const [key, thing] of this.kept) {
      if (this.kept.size <= this.most) return;
      this.kept.delete(key);
      // What is on the screen right now is uploaded anew should it have been this one.
      void thing.then((t) => t.dispose()).catch(() => {});
    }
  }
}
