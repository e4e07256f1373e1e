/** Following an instruction as agents do, for visitors: nothing is kept. `/try?split=S&id=I`; without them any episode. */
import { addHeader, byId, empty, make, run, type Served } from '../elements/page.ts';
import type { Episode } from '../episodes/episode.ts';
import { successDistance } from '../episodes/navigation_errors.ts';
import type { Split } from '../episodes/splits.ts';
import { distancesFrom, lengthOf } from '../scan/distances.ts';
import { viewpointIndex } from '../scan/scan.ts';
import { api } from '../server/api.ts';
import { keyHelp } from '../viewer/controls.ts';
import { agentRules, MiniMap, Viewer } from '../viewer/enfilade-viewer.ts';

declare global {
  interface Window {
    /** For tests, and for the curious at the console. */
    walker?: { viewer: Viewer };
  }
}

interface Chosen {
  readonly split: string;
  readonly episode: Episode;
}
interface EpisodeList { readonly matching: number; readonly episodes: readonly Episode[] }

const ask = (split: string, query: Record<string, string>): Promise<EpisodeList> =>
  api.call(`splits/${encodeURIComponent(split)}/episodes?${new URLSearchParams(query)}`);

/** The episode that the address names, or any whose goal is known and whose building has pictures. */
async function choose(): Promise<Chosen | undefined> {
  const query = new URLSearchParams(location.search);
  const [split, id] = [query.get('split'), query.get('id')];
  if (split && id) {
    const [episode] = (await ask(split, { id })).episodes;
    return episode?.path && { split, episode };
  }
  const [{ splits }, { scans }] = await Promise.all([
    api.call<{ splits: Split[] }>('splits'),
    api.call<{ scans: { scan: string; pictures: boolean }[] }>('scans')]);
  const open = splits.filter(({ instructions, goals_hidden }) => !goals_hidden && instructions > 0);
  const any = <T>(list: readonly T[]): T | undefined => list[Math.floor(Math.random() * list.length)];
  const pictured = scans.filter(({ pictures }) => pictures).sort(() => Math.random() - 0.5);
  for (const { scan } of pictured.slice(0, 20)) {
    const from = any(open);
    if (!from) return undefined;
    const { matching } = await ask(from.split, { scan, limit: '1' });
    if (matching === 0) continue;
    const [episode] = (await ask(from.split, { scan, limit: '1', offset: String(Math.floor(Math.random() * matching)) })).episodes;
    if (episode?.path) return { split: from.split, episode };
  }
  return undefined;
}

/** What came of it, and what to do next. */
function outcome(viewer: Viewer, { split, episode }: Chosen, walk: readonly number[]): HTMLElement {
  const path = episode.path!.map((id) => viewpointIndex(viewer.scan, id));
  const error = distancesFrom(viewer.scan, path.at(-1)!)[walk.at(-1)!]!;
  const good = error < successDistance;
  const map = new MiniMap(viewer);
  map.setPath(path, walk);
  void map.loadPlan(api, true);
  const query = new URLSearchParams({ split, id: episode.instruction_id });
  return make('div', {},
    make('h2', { tabindex: '-1' }, good ? 'You found the goal' : 'You did not find the goal'),
    make('p', { class: good ? 'done' : 'problem' },
      `You walked ${lengthOf(viewer.scan, walk).toFixed(1)} m and stopped ${Number.isFinite(error) ? `${error.toFixed(1)} m from the goal` : 'where no path leads to the goal'}. ` +
      `An agent succeeds within ${successDistance} m.`),
    make('div', { class: 'map' }, map.element),
    make('p', { class: 'note' }, 'Blue: the path that was described. Purple: your walk.'),
    make('p', { class: 'buttons' }, make('a', { href: '/try', class: 'button main' }, 'Next instruction'),
      make('a', { href: `/view?${query}`, class: 'button' }, 'See the path'),
      make('a', { href: `/play?${new URLSearchParams({ split, episode: episode.instruction_id })}`, class: 'button' }, 'Walk it as a language model does')));
}

run(async () => {
  const main = byId('main');
  const chosen = await choose();
  if (!chosen) {
    addHeader(await api.call<Served>('scans'));
    main.classList.remove('wide');
    main.append(make('h1', {}, 'Follow an instruction'), empty('No instruction to follow', 'This data set has no episode with pictures and an open goal.', make('a', { href: '/', class: 'button' }, 'Buildings')));
    return;
  }
  const { split, episode } = chosen;
  history.replaceState(null, '', `?${new URLSearchParams({ split, id: episode.instruction_id })}`); // reload is the same one
  const view = make('div', { class: 'agent' });
  const side = make('aside', { class: 'side', 'aria-label': 'Your task' });
  main.append(make('div', { class: 'view stage' }, view), side);
  const viewer = await Viewer.open(view, { scan: episode.scan, rules: agentRules, viewpoint: episode.start, heading: episode.heading, elevation: 0 });
  addHeader(viewer.scan);
  const walk = [viewer.pose.viewpoint];
  viewer.onChange(({ viewpoint }) => { if (viewpoint !== walk.at(-1)) walk.push(viewpoint); });
  const stop = make('button', { type: 'button', class: 'main' }, 'Stop here');
  const panel = make('div', { class: 'panel' }, make('h1', {}, 'Follow the instruction'), make('p', { class: 'instruction' }, episode.instruction),
    make('p', {}, stop), make('p', { class: 'note' }, 'You see what an agent sees. Drag to look around; click a ring on the floor to go there; stop where you think the goal is. ',
      make('span', { class: 'keys' }, keyHelp(viewer))));
  stop.addEventListener('click', () => {
    const result = outcome(viewer, chosen, walk);
    stop.parentElement!.replaceWith(result);
    result.querySelector('h2')!.focus();
  });
  side.append(panel);
  window.walker = { viewer };
});
