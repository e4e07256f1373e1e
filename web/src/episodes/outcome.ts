/** The outcome of a trajectory whose goal everybody may see: distance, success, and their words. */
import { distancesFrom, lengthOf } from '../scan/distances.ts';
import { type Scan, viewpointIndex } from '../scan/scan.ts';
import type { Episode, Goal } from './episode.ts';
import { successDistance } from './navigation_errors.ts';

/** As the server judges sessions and runs (/api/v1/openapi.json); metres. */
export interface Outcome {
  readonly kind: Goal['kind'];
  /** Ids: of the reference path, of the trajectory, and of where the goal's object, region or turning point is. */
  readonly path: readonly string[];
  readonly walk: readonly string[];
  readonly viewpoints: readonly string[];
  // null: out of reach.
  readonly length: number | null;
  readonly error: number | null;
  readonly success: boolean;
  readonly success_distance: number;
  /** REVERIE: whether the named object is the goal's; null: none was named. */
  readonly answer?: boolean | null;
}

const finite = (metres: number): number | null => (Number.isFinite(metres) ? metres : null);

/** How each kind of goal is reached: the rules of tasks::judge() in C++. Metres to the goal, and success. */
function reached(
  scan: Scan, kind: Goal['kind'], { ends, path, walk }: Readonly<Record<'ends' | 'path' | 'walk', readonly number[]>>,
): [number, boolean] {
  const at = walk.at(-1)!;
  const from = distancesFrom(scan, at);
  const [nearest, toEnd] = [Math.min(Infinity, ...ends.map((v) => from[v]!)), from[path.at(-1)!]!];
  switch (kind) {
    case 'object': case 'region': return [nearest, ends.includes(at)];
    case 'boxes': return [ends.length > 0 ? nearest : toEnd, ends.includes(at) || toEnd < successDistance];
    case 'turning_point': {
      if (walk.includes(ends[0]!)) return [toEnd, toEnd <= successDistance];
      return [nearest + distancesFrom(scan, ends[0]!)[path.at(-1)!]!, false];
    }
    default: return [toEnd, toEnd < successDistance];
  }
}

/**
 * Judges a trajectory in the browser; nothing where the goal is hidden. R2R-Back's turning point counts as named if it was visited.
 * @param walk indices of viewpoints
 */
export function judge(scan: Scan, episode: Pick<Episode, 'path' | 'goal'>, walk: readonly number[]): Outcome | undefined {
  if (!episode.path || walk.length === 0) return undefined;
  const { kind = 'end', viewpoints = [] } = episode.goal ?? {};
  const indices = (ids: readonly string[]) => ids.map((id) => viewpointIndex(scan, id)).filter((v) => v >= 0);
  const [error, success] = reached(scan, kind, { ends: indices(viewpoints), path: indices(episode.path), walk });
  return {
    kind, path: episode.path, walk: walk.map((v) => scan.viewpoints[v]!.id), viewpoints,
    length: finite(lengthOf(scan, walk)), error: finite(error), success, success_distance: successDistance,
  };
}

/** "You walked 8.1 m and stopped 0.7 m from the goal." @param who begins the sentence */
export function outcomeText({ length, error }: Outcome, who = 'You'): string {
  const away = error === null ? 'where no path leads to the goal' : `${error.toFixed(1)} m from the goal`;
  return length === null ? `${who} stopped ${away}.` : `${who} walked ${length.toFixed(1)} m and stopped ${away}.`;
}

/** "Success is to stop nearer than 3 m to the goal." */
export function ruleText({ kind, success_distance: metres }: Pick<Outcome, 'kind' | 'success_distance'>): string {
  switch (kind) {
    case 'object': return 'Success is to stop at a viewpoint that shows the object.';
    case 'region': return 'Success is to stop in the goal’s region.';
    case 'boxes': return `Success is to stop at a viewpoint that shows the object, or nearer than ${metres} m to the end of the reference path.`;
    case 'turning_point': return `Success is to turn back at the turning point, and to stop at most ${metres} m from the end of the reference path.`;
    default: return `Success is to stop nearer than ${metres} m to the goal.`;
  }
}
