/** The viewpoints at which a worker has looked around. */
import type { Direction } from '../geometry/geometry.ts';

const sectors = 12;
/** Twelfths of a turn that make a look around, not a glance on the way: a quarter and what a view shows. */
const enough = 3;

export class Looks {
  private readonly seen = new Map<number, Set<number>>();

  /** Records the middle of the view, at the worker's viewpoint. */
  see(viewpoint: number, { heading }: Direction): void {
    const here = this.seen.get(viewpoint) ?? new Set<number>();
    here.add(Math.floor((heading / (2 * Math.PI)) * sectors) % sectors);
    this.seen.set(viewpoint, here);
  }

  around(viewpoint: number): boolean {
    return (this.seen.get(viewpoint)?.size ?? 0) >= enough;
  }
}
