import { describe, expect, it } from 'vitest';
import { degrees } from '../geometry/geometry.ts';
import { Recorder } from './recorder.ts';

describe('a recorded walk', () => {
  const walk = () => {
    let clock = 100;
    const recorder = new Recorder('a', { heading: 0, elevation: 0 }, [], () => clock);
    return {
      recorder,
      see: (viewpoint: string, heading: number, seconds: number) => {
        clock = 100 + seconds;
        recorder.see(viewpoint, { heading: degrees(heading), elevation: 0 });
      },
    };
  };
  const short = (recorder: Recorder) =>
    recorder.entries().map(({ viewpoint, heading, seconds }) => [viewpoint, Math.round((heading * 180) / Math.PI), seconds]);

  it('has the look before each step, the step, and the last look', () => {
    const { recorder, see } = walk();
    see('a', 5, 1);
    see('a', 8, 2);
    see('b', 8, 3);
    see('b', 8, 4); // nothing new
    see('b', 350, 5);
    expect(short(recorder)).toEqual([['a', 0, 0], ['a', 8, 2], ['b', 8, 3], ['b', 350, 5]]);
    expect(recorder.steps).toBe(1);
  });
  it('leaves no gap of more than half a view in a slow turn', () => {
    const { recorder, see } = walk();
    for (let k = 1; k <= 90; ++k) see('a', k, k);
    const headings = recorder.entries().map(({ heading }) => (heading * 180) / Math.PI);
    expect(headings.at(-1)).toBeCloseTo(90);
    for (const [k, heading] of headings.slice(1).entries()) expect(heading - headings[k]!).toBeLessThanOrEqual(16.001);
  });
  it('measures turns the shorter way round', () => {
    const { recorder, see } = walk();
    see('a', 355, 1);
    see('a', 350, 2);
    expect(short(recorder)).toEqual([['a', 0, 0], ['a', 350, 2]]);
  });
  it('goes on after a reload', () => {
    const before = [{ viewpoint: 'a', heading: 0, elevation: 0, seconds: 0 }, { viewpoint: 'b', heading: 0, elevation: 0, seconds: 9 }];
    let clock = 500;
    const recorder = new Recorder('b', { heading: 0, elevation: 0 }, before, () => clock);
    clock = 503;
    recorder.see('c', { heading: 0, elevation: 0 });
    expect(short(recorder)).toEqual([['a', 0, 0], ['b', 0, 9], ['c', 0, 12]]);
    expect(recorder.steps).toBe(2);
  });
  it('ends where one looked last, once', () => {
    const { recorder, see } = walk();
    see('a', 4, 1);
    expect(recorder.entries()).toHaveLength(2);
    expect(recorder.entries()).toHaveLength(2);
    see('a', 0, 2);
    expect(short(recorder).at(-1)).toEqual(['a', 0, 2]);
  });
  it('keeps steps only, once there are a thousand looks', () => {
    const { recorder, see } = walk();
    for (let k = 1; k < 3000; ++k) see('a', (k * 90) % 360, k);
    see('b', 0, 3000);
    expect(recorder.entries().length).toBeLessThanOrEqual(1002);
    expect(recorder.steps).toBe(1);
  });
});
