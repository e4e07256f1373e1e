/** One building, first person: `/view?split=S&id=I#scan/viewpoint/heading/elevation`. */
import { formatLink, parseLink } from '../deep_link.ts';
import { distancesFrom, lengthOf } from '../distances.ts';
import { addHeader, api, byId, make, run } from '../page.ts';
import { keptResults } from '../results.ts';
import { type Episode, type Layer, type Plan, storeyOf, viewpointIndex } from '../scan.ts';
import { keyHelp } from '../viewer/controls.ts';
import { Legend, MapPanel, MiniMap, Player, storeyName, Viewer } from '../viewer/enfilade-viewer.ts';
import { successDistance } from '../walk_errors.ts';
import './view.css';

declare global {
  interface Window {
    /** For tests, and for the curious at the console. */
    enfilade?: { viewer: Viewer };
  }
}

async function findEpisode(): Promise<Episode | undefined> {
  const query = new URLSearchParams(location.search);
  const [split, id] = [query.get('split'), query.get('id')];
  if (!split || !id) return undefined;
  const { episodes } = await api.call<{ episodes: Episode[] }>(
    `splits/${encodeURIComponent(split)}/episodes?id=${encodeURIComponent(id)}`,
  );
  return episodes[0];
}

/** The layers that some viewpoint has, to be laid over the picture; nothing if there are none. */
function overlayControl(viewer: Viewer, legend: Legend): HTMLElement | undefined {
  const names: [Layer, string][] = [['depth', 'Depth'], ['class', 'Classes']];
  const there = names.filter(([layer]) => viewer.scan.viewpoints.some(({ layers }) => layers.includes(layer)));
  if (there.length === 0) return undefined;
  const select = make('select', {}, new Option('Colour', 'colour'), ...there.map(([layer, name]) => new Option(name, layer)));
  select.addEventListener('change', () => {
    void viewer.setOverlay(select.value as Layer);
    legend.show(select.value as Layer);
  });
  return make('label', { class: 'row' }, 'Show', select);
}

/** Puts a text on the clipboard; false where the browser lets no page do that. */
async function copied(text: string): Promise<boolean> {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    return false; // no permission, or no https
  }
}

/** Buttons over the picture: its link, and the whole screen. */
function tools(view: HTMLElement, viewer: Viewer): HTMLElement {
  const said = make('span', { role: 'status', class: 'said' });
  const share = make('button', { type: 'button' }, 'Share');
  share.addEventListener('click', async () => {
    const { viewpoint, heading, elevation } = viewer.pose;
    const place = { scan: viewer.scan.scan, viewpoint: viewer.scan.viewpoints[viewpoint]!.id, heading, elevation };
    const link = location.href.replace(/#.*$/, '') + formatLink(place);
    said.replaceChildren();
    if (await copied(link)) {
      said.append('Link copied');
      setTimeout(() => said.replaceChildren(), 4000);
      return;
    }
    const field = make('input', { type: 'text', readonly: '', 'aria-label': 'Link to this view' });
    field.value = link;
    said.append(field);
    field.select();
  });
  const bar = make('div', { class: 'view-tools' }, said, share);
  if (document.fullscreenEnabled) {
    const whole = make('button', { type: 'button' }, 'Full screen');
    whole.addEventListener('click', () =>
      void (document.fullscreenElement ? document.exitFullscreen() : view.requestFullscreen()));
    view.addEventListener('fullscreenchange', () => {
      whole.textContent = document.fullscreenElement ? 'Leave full screen' : 'Full screen';
    });
    bar.append(whole);
  }
  return bar;
}

/** "Kitchen, ground floor" over the picture, as far as it is known. */
function placeName(viewer: Viewer): HTMLElement {
  const name = make('p', { class: 'view-place' });
  const show = () => {
    const { viewpoint } = viewer.pose;
    const storey = storeyOf(viewer.scan, viewpoint);
    const parts = [viewer.name(viewpoint), viewer.scan.storeys.length > 1 && storey >= 0 ? storeyName(storey).toLowerCase() : ''];
    const text = parts.filter(Boolean).join(', ');
    name.textContent = text.charAt(0).toUpperCase() + text.slice(1);
    name.hidden = text === '';
  };
  viewer.onChange(show);
  show();
  return name;
}

/** After the first picture, which nobody should wait for longer. */
async function showPlan(viewer: Viewer, panel: MapPanel): Promise<void> {
  const plan: Plan = await api.plan(viewer.scan.scan).catch(() => ({ storeys: [], rooms: [] })); // a map without walls
  viewer.setNames(new Map(plan.rooms.flatMap(({ name, viewpoints }) =>
    name ? viewpoints.map((v) => [v, name] as const) : [])));
  panel.setPlan(plan);
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
  const first = episode?.path?.[1];
  // To where the path goes; where that is hidden, as the episode starts.
  const start = episode && !place
    ? { viewpoint: episode.start, ...(first ? { towards: first } : { heading: episode.heading }) } : {};
  const viewer = await Viewer.open(view, { ...start, ...place, scan });
  addHeader(viewer.scan.synthetic);
  document.title = `${scan} · Enfilade`;
  const map = new MiniMap(viewer);
  const mapPanel = new MapPanel(viewer, map);
  const legend = new Legend(viewer, api);
  const panel = make('div', { class: 'panel' }, make('h1', {}, scan));
  view.append(placeName(viewer), tools(view, viewer), legend.element);
  side.append(make('div', { class: 'map' }, mapPanel.element), panel);
  if (episode) await showEpisode(panel, viewer, map, episode);
  const overlay = overlayControl(viewer, legend);
  panel.append(...(overlay ? [make('div', { class: 'controls' }, overlay)] : []),
    make('p', { class: 'note' }, 'Drag to look, click a disc to go. ', make('span', { class: 'keys' }, keyHelp(viewer))));
  followAddress(viewer);
  window.enfilade = { viewer };
  await showPlan(viewer, mapPanel);
});
