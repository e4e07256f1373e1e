/** Trajectories of submissions to the leaderboard, whose teams show them to everybody. */
import { make } from '../elements/page.ts';
import type { Api } from '../server/api.ts';
import { type FoundEpisode, neighbourPage } from './find_episode.ts';
import { withoutTurns } from './results.ts';
import { splitKey } from './splits.ts';

/** The ids of the viewpoints of a submission's trajectory. Throws ServerError where the client may not see it. */
export async function submittedWalk(api: Api, submission: string, episode: string): Promise<readonly string[]> {
  const { trajectory = [] } = await api.call<{ trajectory?: readonly (readonly [string, number, number])[] }>(
    `submissions/${encodeURIComponent(submission)}/episodes/${encodeURIComponent(episode)}`);
  return withoutTurns(trajectory.map(([viewpoint]) => viewpoint));
}

interface Phase { readonly phase: string; readonly task: string; readonly split: string; readonly goals_secret: boolean }
interface Row { readonly id: number; readonly team: string; readonly method: string; readonly walks_public?: boolean }

/** Links to this page with their trajectories; nothing if there are none of the split. */
export async function submissionLinks(api: Api, found: FoundEpisode): Promise<HTMLElement | undefined> {
  const { phases } = await api.call<{ phases: Phase[] }>('phases');
  const open = phases.filter((phase) => !phase.goals_secret && splitKey(phase) === found.key);
  const boards = await Promise.all(open.map(({ phase }) => api.call<{ rows: Row[] }>(`leaderboards/${encodeURIComponent(phase)}?all=1`)));
  const shown = boards.flatMap(({ rows }) => rows.filter(({ walks_public }) => walks_public));
  if (shown.length === 0) return undefined;
  return make('div', {}, make('h2', {}, 'Trajectories of submissions'), make('ul', { class: 'episode-runs' }, ...shown.map(({ id, team, method }) => {
    const submission = String(id);
    const link = make('a', { href: neighbourPage({ ...found, submission }, found.episode.instruction_id) }, method);
    if (found.submission === submission) link.setAttribute('aria-current', 'true');
    return make('li', {}, link, make('span', { class: 'note' }, ` ${team}`));
  })));
}
