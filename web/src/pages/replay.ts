/**
 * Runs of the arena: `/replay` lists them, `/replay?run=R` a run's episodes, `/replay?run=R&with=R2` compares two runs, and
 * `/replay?run=R&episode=E#3` shows a step, with `&with=R2` of both runs side by side.
 */
import { byId, run } from '../elements/page.ts';
import { compareRuns } from '../replay/comparison.ts';
import { listEpisodes } from '../replay/episode_table.ts';
import { listRuns } from '../replay/run_table.ts';
import './replay.css';

run(async () => {
  const main = byId('main');
  const query = new URLSearchParams(location.search);
  const [name, episode, other] = [query.get('run'), query.get('episode'), query.get('with')];
  if (name && episode) {
    const { showEpisode } = await import('../replay/episode_page.ts'); // lists need no viewer
    await showEpisode(main, name, episode);
  } else if (name && other) await compareRuns(main, name, other);
  else if (name) await listEpisodes(main, name);
  else await listRuns(main);
}, 'This run cannot be shown');
