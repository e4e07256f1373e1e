/** At which viewpoints somebody has looked around. */
import type { Direction } from '../geometry/geometry.ts';

const sectors = 12;
/** So many twelfths of a turn are a look around, not a glance on the way: a quarter and what a view shows. */
const enough = 3;

export class Looks {
  private readonly seen = new Map<number, Set<number>>();

  /** The middle of the view, at a viewpoint where somebody stands. */
  see(viewpoint: number, { heading }: Direction): void {
    const here = this.seen.get(viewpoint) ?? new Set<number>();
    here.add(Math.floor((heading / (2 * Math.PI)) * sectors) % sectors);
    this.seen.set(viewpoint, here);
  }

  around(viewpoint: number): boolean {
    return (this.seen.get(viewpoint)?.size ?? 0) >= enough;
  }
}
