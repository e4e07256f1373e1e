/** Navigation errors of a results file, computed in the browser: the file never leaves it. */
import { distancesFrom } from '../scan/distances.ts';
import { type Scan, viewpointIndex } from '../scan/scan.ts';
import type { Api } from '../server/api.ts';
import type { Episode } from './episode.ts';
import type { Results } from './results.ts';

/** Metres; a walk that stops nearer to its goal is a success. The paper's. */
export const successDistance = 3;

/** Errors within one building, which is looked through once a goal. Infinite out of reach. */
export class ErrorMeter {
  private readonly scan: Scan;
  private readonly distances = new Map<number, readonly number[]>();

  constructor(scan: Scan) {
    this.scan = scan;
  }

  /** Metres from where the walk stops to the goal; nothing if the walk is of another building. */
  error(goal: string, stop: string): number | undefined {
    const [to, at] = [viewpointIndex(this.scan, goal), viewpointIndex(this.scan, stop)];
    if (to < 0 || at < 0) return undefined;
    const known = this.distances.get(to) ?? distancesFrom(this.scan, to);
    this.distances.set(to, known);
    return known[at];
  }
}

/** By instruction id: the error of each walk whose goal is known. */
export async function errorsOf(api: Api, episodes: readonly Episode[], results: Results): Promise<ReadonlyMap<string, number>> {
  const meters = new Map<string, Promise<ErrorMeter>>();
  const meterOf = (scan: string) => {
    const known = meters.get(scan) ?? api.scan(scan).then((one) => new ErrorMeter(one));
    meters.set(scan, known);
    return known;
  };
  const errors = new Map<string, number>();
  await Promise.all(episodes.map(async ({ instruction_id, scan, path }) => {
    const [goal, stop] = [path?.at(-1), results.get(instruction_id)?.viewpoints.at(-1)];
    if (goal === undefined || stop === undefined) return;
    const error = (await meterOf(scan)).error(goal, stop);
    if (error !== undefined) errors.set(instruction_id, error);
  }));
  return errors;
}
