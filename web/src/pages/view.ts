/** One building, first person: `/view?split=S&id=I#scan/viewpoint/heading/elevation`. */
import { linkCopier } from '../elements/link_copier.ts';
import { addHeader, byId, make, run } from '../elements/page.ts';
import type { Episode } from '../episodes/episode.ts';
import { showEpisode } from '../episodes/episode_panel.ts';
import { episodesOf } from '../episodes/splits.ts';
import { type Layer, type Plan, storeyOf, viewpointIndex } from '../scan/scan.ts';
import { api } from '../server/api.ts';
import { keyHelp } from '../viewer/controls.ts';
import { formatLink, parseLink } from '../viewer/deep_link.ts';
import { Legend, MapPanel, MiniMap, storeyName, Viewer } from '../viewer/enfilade-viewer.ts';
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
  const { episodes } = await api.call<{ episodes: Episode[] }>(episodesOf(split, { id }));
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

/** A link to /roam at this position and heading; with the path of the episode that is shown. */
function roamLink(viewer: Viewer): HTMLElement {
  const link = make('a', { class: 'button' }, 'Walk anywhere');
  const { split, id } = Object.fromEntries(new URLSearchParams(location.search)) as { split?: string; id?: string };
  // An instruction's id is its path's and a number; continuous episodes are of R2R's paths.
  const episode = split && !split.includes('/') && id ? `?${new URLSearchParams({ split, trajectory: id.replace(/_\d+$/, '') })}` : '';
  const aim = () => {
    const { viewpoint, heading, elevation } = viewer.pose;
    link.href = `/roam${episode}${formatLink({ scan: viewer.scan.scan, viewpoint: viewer.scan.viewpoints[viewpoint]!.id, heading, elevation })}`;
  };
  viewer.onChange(aim);
  aim();
  return link;
}

/** Buttons over the picture: its link, and the whole screen. */
function tools(view: HTMLElement, viewer: Viewer): HTMLElement {
  const { button: share, said } = linkCopier('Share', 'Link to this view', () => {
    const { viewpoint, heading, elevation } = viewer.pose;
    const place = { scan: viewer.scan.scan, viewpoint: viewer.scan.viewpoints[viewpoint]!.id, heading, elevation };
    return location.href.replace(/#.*$/, '') + formatLink(place);
  });
  const bar = make('div', { class: 'view-tools' }, said, ...(viewer.scan.roam ? [roamLink(viewer)] : []), share);
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

/** After the first picture, so as not to delay it. */
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
  addHeader(viewer.scan);
  document.title = `${scan} · Enfilade`;
  const map = new MiniMap(viewer);
  const mapPanel = new MapPanel(viewer, map);
  const legend = new Legend(viewer, api);
  const panel = make('div', { class: 'panel' }, make('h1', {}, scan));
  view.append(placeName(viewer), tools(view, viewer), legend.element);
  side.append(make('div', { class: 'map' }, mapPanel.element), panel);
  if (episode) await showEpisode(panel, viewer, map, episode, new URLSearchParams(location.search).get('split') ?? '');
  const overlay = overlayControl(viewer, legend);
  panel.append(...(overlay ? [make('div', { class: 'controls' }, overlay)] : []),
    make('p', { class: 'note' }, 'Drag to look, click a disc to go. ', make('span', { class: 'keys' }, keyHelp(viewer))));
  followAddress(viewer);
  window.enfilade = { viewer };
  await showPlan(viewer, mapPanel);
});
