/** One building, first person: `/view?split=S&id=I#scan/viewpoint/heading/elevation`. */
import { fullScreenButton } from '../elements/full_screen.ts';
import { lacksGraphics } from '../elements/graphics.ts';
import { noBuilding, showInstead } from '../elements/instead.ts';
import { linkCopier } from '../elements/link_copier.ts';
import { addHeader, byId, make, run } from '../elements/page.ts';
import { buildingEpisodes } from '../episodes/building_episodes.ts';
import { showEpisode } from '../episodes/episode_panel.ts';
import { findEpisode } from '../episodes/find_episode.ts';
import { type Layer, namesByViewpoint, type Plan, storeyOf, viewpointIndex } from '../scan/scan.ts';
import { api, passSilence } from '../server/api.ts';
import { keyHelp } from '../viewer/controls.ts';
import { formatLink, parseLink, type Place } from '../viewer/deep_link.ts';
import { Legend, MapPanel, MiniMap, storeyName, type Viewer } from '../viewer/enfilade-viewer.ts';
import { openNamed } from '../viewer/open_named.ts';
import { roomCards } from '../viewer/room_cards.ts';
import './view.css';

declare global {
  interface Window {
    /** For tests, and for the curious at the console. */
    enfilade?: { viewer: Viewer };
  }
}

/** Where one stands and looks, as addresses have it. */
function placeOf(viewer: Viewer): Place {
  const { viewpoint, heading, elevation } = viewer.pose;
  return { scan: viewer.scan.scan, viewpoint: viewer.scan.viewpoints[viewpoint]!.id, heading, elevation };
}

/** The layers that some viewpoint has, to be laid over the picture; nothing if there are none. */
function layerControl(viewer: Viewer, legend: Legend): HTMLElement | undefined {
  const names: [Layer, string][] = [['depth', 'Depth'], ['class', 'Semantic']];
  const there = names.filter(([layer]) => viewer.scan.viewpoints.some(({ layers }) => layers.includes(layer)));
  if (there.length === 0) return undefined;
  const select = make('select', {}, new Option('RGB', 'colour'), ...there.map(([layer, name]) => new Option(name, layer)));
  select.addEventListener('change', () => {
    viewer.setOverlay(select.value as Layer).catch(passSilence);
    legend.show(select.value as Layer);
  });
  return make('div', { class: 'controls' }, make('label', { class: 'row' }, 'Layer', select));
}

/** A link whose address follows where one stands and looks. */
function following(viewer: Viewer, text: string, address: (place: Place) => string): HTMLElement {
  const link = make('a', { class: 'button' }, text);
  const aim = () => (link.href = address(placeOf(viewer)));
  viewer.onChange(aim);
  aim();
  return link;
}

/** A link to /roam at this position and heading; with the path of the episode that is shown. */
function roamLink(viewer: Viewer): HTMLElement {
  const { split, id } = Object.fromEntries(new URLSearchParams(location.search)) as { split?: string; id?: string };
  // An instruction's id is its path's and a number; continuous episodes are of R2R's paths.
  const episode = split && !split.includes('/') && id ? `?${new URLSearchParams({ split, trajectory: id.replace(/_\d+$/, '') })}` : '';
  return following(viewer, 'Walk anywhere', (place) => `/roam${episode}${formatLink(place)}`);
}

/** Over the picture: where one is, the view's link, and the whole screen. */
function head(view: HTMLElement, viewer: Viewer, ...along: readonly HTMLElement[]): HTMLElement {
  const { button: share, said } = linkCopier('Share', 'Link to this view', () => location.href.replace(/#.*$/, '') + formatLink(placeOf(viewer)));
  const whole = fullScreenButton(view, ...along);
  return make('div', { class: 'view-head' }, placeName(viewer),
    make('div', { class: 'view-tools' }, said, ...(viewer.scan.roam ? [roamLink(viewer)] : []), share, ...(whole ? [whole] : [])));
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

function followAddress(viewer: Viewer): void {
  let ours = location.hash;
  let timer = 0;
  viewer.onChange(() => {
    clearTimeout(timer); // browsers refuse a new address for every frame of a drag
    timer = window.setTimeout(() => {
      ours = formatLink(placeOf(viewer));
      history.replaceState(null, '', ours);
    }, 200);
  });
  addEventListener('hashchange', () => {
    if (location.hash === ours) return;
    const place = parseLink(location.hash);
    const viewpoint = viewpointIndex(viewer.scan, place?.viewpoint);
    if (place?.scan !== viewer.scan.scan || (place.viewpoint !== undefined && viewpoint < 0)) return location.reload();
    const { heading, elevation } = place;
    viewer.jump({
      ...(viewpoint >= 0 && { viewpoint }), ...(heading !== undefined && { heading }), ...(elevation !== undefined && { elevation }),
    }).catch(passSilence);
  });
}

/** Where the pictures of the building in lists are taken from: where most is to be seen. */
async function outlook(scan: string): Promise<Partial<Place>> {
  const { viewpoint, heading } = await api.call<Required<Place>>(`scans/${encodeURIComponent(scan)}/outlook`);
  return { viewpoint, heading };
}

/** What else the panel has. Nothing that is there moves when more comes. */
async function fillPanel(panel: HTMLElement, viewer: Viewer, map: MapPanel): Promise<void> {
  const [rooms, episodes] = [make('div'), make('div')];
  panel.append(rooms, episodes);
  const plan: Plan = await api.plan(viewer.scan.scan).catch(() => ({ storeys: [], rooms: [] })); // a map without walls
  viewer.setNames(namesByViewpoint(plan));
  map.setPlan(plan);
  const cards = roomCards(viewer, plan, api);
  if (cards) rooms.append(cards);
  const list = await buildingEpisodes(api, viewer.scan.scan).catch(() => undefined);
  if (list) episodes.append(list);
}

run(async () => {
  if (lacksGraphics()) return;
  const found = await findEpisode(api, location.search);
  if (found instanceof HTMLElement) return showInstead('Episode', found);
  const episode = found?.episode;
  const place = parseLink(location.hash);
  const scan = place?.scan ?? episode?.scan;
  if (!scan) return showInstead('View', noBuilding(undefined));
  const [view, side, mapBox] = [make('div', { class: 'view' }), make('aside', { class: 'side' }), make('div', { class: 'map' })];
  side.append(mapBox);
  byId('main').append(view, side);
  const first = episode?.path?.[1];
  // To where the path goes; where that is hidden, as the episode starts.
  const start = episode && !place ? { viewpoint: episode.start, ...(first ? { towards: first } : { heading: episode.heading }) }
    : place?.viewpoint === undefined ? await outlook(scan).catch(() => ({})) : {};
  const viewer = await openNamed(view, { ...start, ...place, scan }, { name: 'View', path: '/view' });
  if (!viewer) return;
  addHeader(viewer.scan);
  document.title = `${scan} · Enfilade`;
  const map = new MiniMap(viewer);
  const mapPanel = new MapPanel(viewer, map);
  const legend = new Legend(viewer, api);
  const [panel, about] = [make('div', { class: 'panel' }), make('div', { class: 'episode' })];
  mapBox.append(mapPanel.element);
  side.append(panel);
  view.append(legend.element);
  panel.append(about);
  if (found) await showEpisode(about, viewer, map, found);
  else about.append(make('h1', {}, scan));
  view.append(head(view, viewer, mapBox, ...(found ? [about] : [])));
  const layers = layerControl(viewer, legend);
  panel.append(...(layers ? [layers] : []),
    make('p', { class: 'buttons' }, following(viewer, 'Verify graph', (at) => `/verify${formatLink(at)}`)),
    make('p', { class: 'note' }, 'Drag to look, click a disc to go. ', make('span', { class: 'keys' }, keyHelp(viewer))));
  followAddress(viewer);
  window.enfilade = { viewer };
  await fillPanel(panel, viewer, mapPanel);
});
