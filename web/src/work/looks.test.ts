import { describe, expect, it } from 'vitest';
import { degrees } from '../geometry/geometry.ts';
import { lookedAround, Looks } from './looks.ts';

describe('looking around', () => {
  it('is three twelfths of a turn at the same viewpoint', () => {
    const looks = new Looks();
    const see = (viewpoint: number, heading: number) => looks.see(viewpoint, { heading: degrees(heading), elevation: 0 });
    see(1, 10);
    see(1, 40);
    see(2, 70);
    expect(looks.around(1)).toBe(false);
    see(1, 359.9);
    expect(looks.around(1)).toBe(true);
    expect(looks.around(2)).toBe(false);
  });
  it('is told in words', () => {
    expect(lookedAround(0, 3)).toBe('You have not looked around yet.');
    expect(lookedAround(2, 3)).toBe('You have looked around at 2 of them.');
    expect(lookedAround(3, 3)).toBe('You have looked around at each of them.');
  });
});
