import { describe, expect, it } from 'vitest';
import { Pace } from './pace.ts';

/** Draws frames on a machine that takes so long for a whole picture and for what has no pixels. Returns the last frame's time. */
function draw(pace: Pace, frames: number, whole: number, fixed: number): number {
  let took = 0;
  for (let k = 0; k < frames; ++k) {
    took = Math.max(fixed + whole * pace.scale ** 2, 16);
    pace.took(took);
  }
  return took;
}

describe('the pace of drawing', () => {
  it('comes to 15 frames a second on a slow machine, soon', () => {
    const pace = new Pace(0.25);
    expect(draw(pace, 15, 300, 10)).toBeLessThan(1000 / 15);
    expect(pace.scale).toBeGreaterThan(0.25);
  });
  it('does not go below the least', () => {
    const pace = new Pace(0.25);
    draw(pace, 60, 5000, 100);
    expect(pace.scale).toBe(0.25);
  });
  it('leaves a quick machine all its pixels', () => {
    const pace = new Pace(0.25);
    draw(pace, 100, 8, 2);
    expect(pace.scale).toBe(1);
  });
  it('grows again where there is time, and does not swing', () => {
    const pace = new Pace(0.25, 0.35);
    draw(pace, 400, 10, 5);
    expect(pace.scale).toBe(1);
    const between = new Pace(0.25, 0.35); // quick at 0.35, too slow at 0.42
    const scales: number[] = [];
    for (let k = 0; k < 600; ++k) {
      between.took(between.scale > 0.4 ? 80 : 18);
      if (scales.at(-1) !== between.scale) scales.push(between.scale);
    }
    expect(scales.length).toBeLessThan(5);
    expect(between.scale).toBeLessThan(0.4);
  });
  it('does not shrink for one slow frame', () => {
    const pace = new Pace(0.25);
    for (let k = 0; k < 40; ++k) pace.took(k % 10 === 5 ? 900 : 20);
    expect(pace.scale).toBe(1);
  });
});
