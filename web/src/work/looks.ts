/** The viewpoints at which a worker has looked around. */
import type { Direction } from '../geometry/geometry.ts';

const sectors = 12;
/** Twelfths of a turn that make a look around, not a glance on the way: a quarter and what a view shows. */
const enough = 3;

/** How many of a path's places one has looked around at, in words. */
export const lookedAround = (seen: number, all: number): string =>
  seen === 0 ? 'You have not looked around yet.' : `You have looked around at ${seen === all ? 'each of them' : `${seen} of them`}.`;

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
