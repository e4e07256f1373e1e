/** One building, first person: `/view?split=S&id=I#scan/viewpoint/heading/elevation`. */
import { formatLink, parseLink } from '../deep_link.ts';
import { distancesFrom, lengthOf } from '../distances.ts';
import { addHeader, api, byId, make, run } from '../page.ts';
import { keptResults } from '../results.ts';
import { type Episode, type Layer, viewpointIndex } from '../scan.ts';
import { keyHelp } from '../viewer/controls.ts';
import { MiniMap, Player, Viewer } from '../viewer/enfilade-viewer.ts';

declare global {
  interface Window {
    /** For tests, and for the curious at the console. */
    enfilade?: { viewer: Viewer };
  }
}

/** Metres; the paper's. */
const successDistance = 3;

async function findEpisode(): Promise<Episode | undefined> {
  const query = new URLSearchParams(location.search);
  const [split, id] = [query.get('split'), query.get('id')];
  if (!split || !id) return undefined;
  const { episodes } = await api.call<{ episodes: Episode[] }>(
    `splits/${encodeURIComponent(split)}/episodes?id=${encodeURIComponent(id)}`,
  );
  return episodes[0];
}

function overlayControl(viewer: Viewer): HTMLElement {
  const select = make('select', {}, new Option('Colours only', 'colour'),
    new Option('Depth over them', 'depth'), new Option('Classes over them', 'class'));
  select.addEventListener('change', () => void viewer.setOverlay(select.value as Layer));
  return make('label', { class: 'row' }, 'Show', select);
}

function followAddress(viewer: Viewer): void {
  let ours = location.hash;
  let timer = 0;
  viewer.onChange(({ viewpoint, heading, elevation }) => {
    clearTimeout(timer); // browsers refuse a new address for every frame of a drag
    timer = window.setTimeout(() => {
      const { id } = viewer.scan.viewpoints[viewpoint]!;
      ours = formatLink({ scan: viewer.scan.scan, viewpoint: id, heading, elevation });
      history.replaceState(null, '', ours);
    }, 200);
  });
  addEventListener('hashchange', () => {
    if (location.hash === ours) return;
    const place = parseLink(location.hash);
    if (place?.scan !== viewer.scan.scan) return location.reload();
    const viewpoint = viewpointIndex(viewer.scan, place.viewpoint);
    const { heading, elevation } = { ...viewer.pose, ...place };
    void viewer.jump({ heading, elevation, ...(viewpoint >= 0 && { viewpoint }) });
  });
}

/** How a walk ended, as the tables measure it. */
function verdict(viewer: Viewer, path: readonly number[], walk: readonly number[]): HTMLElement {
  const error = distancesFrom(viewer.scan, path.at(-1)!)[walk.at(-1)!]!;
  const away = Number.isFinite(error) ? `${error.toFixed(1)} m from the goal` : 'out of reach of the goal';
  return make('p', { class: error < successDistance ? 'done' : 'problem' },
    `The agent walked ${lengthOf(viewer.scan, walk).toFixed(1)} m and stopped ${away}: ` +
      (error < successDistance ? 'a success.' : 'no success.'));
}

async function showEpisode(panel: HTMLElement, viewer: Viewer, map: MiniMap, episode: Episode): Promise<void> {
  const indices = (ids: readonly string[]) => ids.map((id) => viewpointIndex(viewer.scan, id));
  const path = indices(episode.path ?? []);
  const results = await keptResults(new URLSearchParams(location.search).get('split') ?? '');
  const walk = indices(results?.get(episode.instruction_id)?.viewpoints ?? []);
  if (walk.includes(-1)) throw new Error(`${episode.instruction_id}: the results are of another building`);
  viewer.setPath(path);
  map.setPath(path, walk);
  panel.append(make('p', { class: 'instruction' }, episode.instruction));
  if (path.length === 0) panel.append(make('p', { class: 'note' }, 'The goal of this one is hidden.'));
  if (path.length > 0) {
    panel.append(make('h2', {}, 'Reference path'), new Player(viewer, path).element,
      make('p', { class: 'note' }, `${path.length} viewpoints, ${episode.distance ?? '?'} m`));
  }
  if (walk.length > 0) {
    const player = new Player(viewer, walk);
    player.element.setAttribute('aria-label', "Fly-through of the agent's path");
    panel.append(make('h2', {}, "The agent's path"), player.element);
    if (path.length > 0) panel.append(verdict(viewer, path, walk));
  }
}

run(async () => {
  const [view, side] = [make('div', { class: 'view' }), make('aside', { class: 'side' })];
  byId('main').append(view, side);
  const episode = await findEpisode();
  const place = parseLink(location.hash);
  const scan = place?.scan ?? episode?.scan;
  if (!scan) throw new Error('The address names no building: /view#scan/viewpoint');
  const start = episode && !place ? { viewpoint: episode.start, heading: episode.heading } : {};
  const viewer = await Viewer.open(view, { ...start, ...place, scan });
  addHeader(viewer.scan.synthetic);
  document.title = `${scan} · Enfilade`;
  const map = new MiniMap(viewer);
  const panel = make('div', { class: 'panel' }, make('h1', {}, scan));
  side.append(make('div', { class: 'map' }, map.element), panel);
  if (episode) await showEpisode(panel, viewer, map, episode);
  panel.append(make('div', { class: 'controls' }, overlayControl(viewer)),
    make('p', { class: 'note' }, 'Drag to look, click a disc to go. ', make('span', { class: 'keys' }, keyHelp(viewer))));
  followAddress(viewer);
  window.enfilade = { viewer };
});
