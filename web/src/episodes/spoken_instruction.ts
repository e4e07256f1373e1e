/** An instruction that was spoken while walking, in its time: which word is said, and where one is then. */
import { directionTo, norm, subtract, wrapDifference, wrapHeading } from '../geometry/geometry.ts';
import { type Scan, viewpointIndex } from '../scan/scan.ts';
import type { Moment, Timeline } from '../viewer/flight.ts';
import type { TimedWord, Trace } from './episode.ts';

/** Of a leg, from its start on: while one turns to the next viewpoint. */
const turning = 0.25;

interface Leg {
  readonly from: number;
  readonly to: number;
  readonly heading: number;
  /** Metres from the start of the path to that of the leg. */
  readonly start: number;
  readonly metres: number;
}

/** Seconds until the last word has been said; 0 where no word has a time. */
export const lengthOf = (words: readonly TimedWord[]): number =>
  Math.max(0, ...words.map(({ start, end }) => end ?? start ?? 0));

/** Index of the word that is said, or was said last; -1 before the first one. */
export function wordAt(words: readonly TimedWord[], seconds: number): number {
  let said = -1;
  words.forEach(({ start }, k) => {
    if (start !== undefined && start <= seconds) said = k;
  });
  return said;
}

/**
 * Walks a path evenly in the time that its instruction takes: where nothing is known but the words'
 * times, as guides began at the start and ended at the goal.
 */
export class EvenWalk implements Timeline {
  readonly seconds: number;
  private readonly legs: readonly Leg[];
  private readonly metres: number;
  private readonly last: number;

  /** @param path viewpoints, each next to the one before; at least one */
  constructor(scan: Scan, path: readonly number[], seconds: number, heading: number) {
    this.seconds = seconds;
    let start = 0;
    this.legs = path.slice(1).map((to, k) => {
      const from = path[k]!;
      const [a, b] = [scan.viewpoints[from]!.position, scan.viewpoints[to]!.position];
      const leg = { from, to, heading: directionTo(a, b).heading, start, metres: norm(subtract(b, a)) };
      start += leg.metres;
      return leg;
    });
    this.metres = start;
    this.last = path.at(-1)!;
    this.heading = this.legs[0]?.heading ?? heading;
  }

  private readonly heading: number;

  at(seconds: number): Moment {
    const done = this.metres * Math.min(Math.max(seconds / this.seconds, 0), 1);
    const k = this.legs.findIndex(({ start, metres }) => done < start + metres);
    const leg = this.legs[k];
    if (!leg) return { from: this.last, to: this.last, share: 0, heading: this.legs.at(-1)?.heading ?? this.heading, elevation: 0 };
    const share = (done - leg.start) / leg.metres;
    const before = this.legs[k - 1]?.heading ?? leg.heading;
    const turned = Math.min(share / turning, 1);
    const heading = wrapHeading(before + turned * wrapDifference(leg.heading - before));
    return { from: leg.from, to: leg.to, share, heading, elevation: 0 };
  }
}

/** Of the time at a viewpoint, before one goes on: while one is on the way, seconds at most. */
const step = 0.5;

/** Looks as a guide did. Throws Error for a trace of another building. */
export class TraceWalk implements Timeline {
  readonly seconds: number;
  private readonly trace: Trace;
  private readonly places: readonly number[];
  private readonly scan: Scan;

  /** @param seconds at least so long, for words after the last look */
  constructor(scan: Scan, trace: Trace, seconds = 0) {
    this.scan = scan;
    this.trace = trace;
    this.places = trace.viewpoints.map((id) => viewpointIndex(scan, id));
    if (this.places.includes(-1)) throw new Error('the pose trace is of another building');
    this.seconds = Math.max(trace.times.at(-1) ?? 0, seconds);
  }

  at(seconds: number): Moment {
    const { times, headings, elevations } = this.trace;
    const next = times.findIndex((time) => time > seconds);
    const last = times.length - 1;
    const k = next < 0 ? last : Math.max(next - 1, 0);
    const [from, heading, elevation] = [this.places[k]!, headings[k]!, elevations[k]!];
    if (k === last || seconds <= times[k]!) return { from, to: from, share: 0, heading, elevation };
    const left = times[k + 1]! - seconds;
    const to = this.places[k + 1]!;
    if (to !== from) { // one stands still, then goes, if it is a step
      const took = Math.min(step, times[k + 1]! - times[k]!);
      const share = this.scan.viewpoints[from]!.neighbours.includes(to) ? Math.max(1 - left / took, 0) : 0;
      return { from, to: share > 0 ? to : from, share, heading, elevation };
    }
    const share = 1 - left / (times[k + 1]! - times[k]!);
    const turn = wrapDifference(headings[k + 1]! - heading);
    return { from, to, share: 0, heading: wrapHeading(heading + share * turn), elevation: elevation + share * (elevations[k + 1]! - elevation) };
  }
}
