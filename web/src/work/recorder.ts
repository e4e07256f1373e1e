/** A walk as it is taken: where, how one looked, and when. */
import type { Entry } from '../collecting/collections.ts';
import { type Direction, wrapDifference } from '../geometry/geometry.ts';

/** A look is an entry of its own once it is so far from the entry before: half a view of R2R's 36. */
const turned = Math.PI / 12;
/** Beyond this number of entries only steps are kept, so that an hour of spinning doesn't fill a disk. */
const mostLooks = 1000;

export class Recorder {
  private readonly now: () => number;
  private readonly begin: number;
  private readonly list: Entry[];
  /** The latest look, should it not be an entry yet. */
  private pending: Entry | undefined;

  /**
   * @param before entries of a walk that was interrupted here: time goes on from the last one
   * @param now seconds, from any beginning
   */
  constructor(
    viewpoint: string,
    look: Direction,
    before: readonly Entry[] = [],
    now: () => number = () => performance.now() / 1000,
  ) {
    this.now = now;
    this.list = [...before];
    this.begin = now() - (before.at(-1)?.seconds ?? 0);
    this.see(viewpoint, look);
  }

  /** Since the walk began. */
  get seconds(): number {
    return this.now() - this.begin;
  }

  /** To be called whenever the pose changes. */
  see(viewpoint: string, { heading, elevation }: Direction): void {
    const entry = { viewpoint, heading, elevation, seconds: this.now() - this.begin };
    const last = this.list.at(-1);
    if (last?.viewpoint !== viewpoint) {
      this.flush(); // a step is taken from where one looked last
      this.list.push(entry);
      return;
    }
    const angle = Math.hypot(wrapDifference(heading - last.heading), elevation - last.elevation);
    this.pending = angle > 0 ? entry : undefined;
    if (angle >= turned && this.list.length < mostLooks) this.flush();
  }

  /** So far, the present look included. */
  entries(): readonly Entry[] {
    this.flush();
    return this.list;
  }

  /** Steps from viewpoint to viewpoint so far. */
  get steps(): number {
    return this.list.filter((entry, k) => k > 0 && entry.viewpoint !== this.list[k - 1]!.viewpoint).length;
  }

  private flush(): void {
    if (this.pending) this.list.push(this.pending);
    this.pending = undefined;
  }
}
