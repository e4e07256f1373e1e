/** Continuous walking in a building: `/roam?split=S&id=I#scan/viewpoint/heading/elevation`, or `@x,y,z` in the viewpoint's place. */
import { addHeader, byId, facts, loading, make, run, say } from '../elements/page.ts';
import { type Direction, directionTo, type Vec3 } from '../geometry/geometry.ts';
import { houseHelp, keyHelp, RoamControls } from '../roam/controls.ts';
import { Floor, type FloorData, type FloorPoint } from '../roam/floor.ts';
import { parseGlb } from '../roam/glb.ts';
import { footOf, formatPoint, nearestViewpoint, parsePoint } from '../roam/places.ts';
import { RoamMap } from '../roam/roam_map.ts';
import { type Mode, RoamView } from '../roam/roam_view.ts';
import { ceilingOf, storeyAt } from '../roam/storeys.ts';
import { type Action, Walker } from '../roam/walker.ts';
import { type Scan, viewpointIndex } from '../scan/scan.ts';
import { api } from '../server/api.ts';
import { formatLink, parseLink, type Place } from '../viewer/deep_link.ts';
import { storeyName } from '../viewer/storey_name.ts';
import '../viewer/styled.ts';
import './view.css';
import './roam.css';

declare global {
  interface Window {
    /** For tests, and for the curious at the console. */
    roaming?: { readonly walker: Walker; readonly view: RoamView };
  }
}

/** A continuous episode, as the server tells it. */
interface ContinuousEpisode {
  readonly id: string;
  readonly trajectory: string;
  readonly scan: string;
  readonly instruction: string;
  readonly language?: string;
  readonly start: Vec3;
  readonly heading: number;
  /** Absent where goals are hidden. */
  readonly path?: readonly Vec3[];
  readonly goals?: readonly { readonly position: Vec3; readonly radius: number }[];
  readonly distance?: number;
}

const query = new URLSearchParams(location.search);
const pathOf = (scan: string): string => `scans/${encodeURIComponent(scan)}`;

/** `id` of an episode, or `trajectory`: the first of that path. */
async function findEpisode(): Promise<ContinuousEpisode | undefined> {
  const split = query.get('split');
  const which = ['id', 'trajectory'].find((name) => query.has(name));
  if (!split || !which) return undefined;
  const wanted = new URLSearchParams({ [which]: query.get(which)!, limit: '1' });
  const { episodes } = await api.call<{ episodes: ContinuousEpisode[] }>(`continuous/${encodeURIComponent(split)}/episodes?${wanted}`);
  return episodes[0];
}

async function fetchMesh(scan: string): Promise<ArrayBuffer> {
  const response = await fetch(`${api.base}/api/v1/${pathOf(scan)}/mesh.glb`);
  if (!response.ok) {
    const answer = (await response.json().catch(() => undefined)) as { error?: { message: string } } | undefined;
    throw new Error(answer?.error?.message ?? `the server answered with status ${response.status}`);
  }
  return response.arrayBuffer();
}

/** Where one begins: as the address says, else as the episode does, else at the first viewpoint with pictures. */
function beginning(floor: Floor, scan: Scan, place: Place | undefined, episode: ContinuousEpisode | undefined): readonly [FloorPoint, Direction] {
  const point = parsePoint(place?.viewpoint);
  const named = viewpointIndex(scan, place?.viewpoint);
  const first = Math.max(scan.viewpoints.findIndex(({ rotation }) => rotation), 0);
  const feet = point ?? (named >= 0 ? footOf(scan, named) : episode?.start ?? footOf(scan, first));
  const at = floor.nearest(feet);
  if (!at) throw new Error('The floor of this building is empty');
  const next = scan.viewpoints[first]?.neighbours[0];
  const open = next === undefined ? 0 : directionTo(feet, footOf(scan, next)).heading;
  const ours = point !== undefined || named >= 0 ? 0 : episode?.heading ?? open;
  return [at, { heading: place?.heading ?? ours, elevation: place?.elevation ?? 0 }];
}

const button = (text: string, act: () => void, attributes: Record<string, string> = {}): HTMLButtonElement => {
  const made = make('button', { type: 'button', ...attributes }, text);
  made.addEventListener('click', act);
  return made;
};

const press = (buttons: readonly HTMLElement[], on: number): void =>
  buttons.forEach((one, k) => one.setAttribute('aria-pressed', String(k === on)));

const choice = (label: string, ...buttons: readonly HTMLElement[]): HTMLElement =>
  make('div', { class: 'enfilade-choice', role: 'group', 'aria-label': label }, ...buttons);

class Page {
  private readonly scan: Scan;
  private readonly walker: Walker;
  private readonly view: RoamView;
  private readonly controls: RoamControls;
  private readonly episode: ContinuousEpisode | undefined;
  private readonly floors: readonly number[];
  private readonly modes: readonly HTMLButtonElement[];
  private readonly storeys: readonly HTMLButtonElement[];
  private readonly storeyChoice: HTMLElement;
  private readonly pad: HTMLElement;
  private readonly help = make('p', { class: 'note keys' });
  private readonly numbers = make('div', {});
  private readonly said = make('p', { class: 'enfilade-said', 'aria-live': 'polite' });
  private readonly panorama = make('a', { class: 'button' }, 'Panorama near here');
  private storey: number;
  private timer = 0;

  constructor(scan: Scan, walker: Walker, view: RoamView, episode: ContinuousEpisode | undefined) {
    [this.scan, this.walker, this.view, this.episode] = [scan, walker, view, episode];
    this.floors = scan.storeys.map(({ floor }) => floor);
    this.storey = storeyAt(this.floors, walker.position[2]);
    this.controls = new RoamControls(view, walker, (action, touched) => this.tell(action, touched), (x, y) => this.goTo(x, y));
    this.modes = [button('Walk', () => this.show('inside')), button('Doll’s house', () => this.show('house'))];
    this.storeys = this.floors.map((_, k) => button(String(k), () => this.showStorey(k), { 'aria-label': storeyName(k) }));
    this.storeyChoice = choice('Storeys', ...this.storeys);
    this.pad = this.makePad();
    walker.onChange(() => this.follow());
  }

  build(main: HTMLElement, map: RoamMap): void {
    const view = make('div', { class: 'view' }, this.view.element,
      make('div', { class: 'view-tools' }, choice('View', ...this.modes), this.storeyChoice), this.pad, this.said);
    const panel = make('div', { class: 'panel' }, make('h1', {}, this.scan.scan), ...this.aboutEpisode(), this.numbers,
      make('p', { class: 'buttons' }, this.panorama, button('Back to the start', () => this.restart())), this.help);
    main.replaceChildren(view, make('aside', { class: 'side' }, make('div', { class: 'map' }, map.element), panel));
    this.show('inside');
    this.follow();
  }

  private show(mode: Mode): void {
    press(this.modes, mode === 'inside' ? 0 : 1);
    this.storeyChoice.hidden = mode === 'inside' || this.storeys.length < 2;
    this.pad.hidden = mode === 'house';
    this.help.textContent = mode === 'inside' ? `Drag to look around. ${keyHelp}` : `Drag to turn it; a click on a floor puts you there. ${houseHelp}`;
    this.storey = storeyAt(this.floors, this.walker.position[2]);
    press(this.storeys, this.storey);
    this.view.show(mode, ceilingOf(this.floors, this.storey));
    this.controls.name();
  }

  private showStorey(storey: number): void {
    this.storey = storey;
    press(this.storeys, storey);
    this.view.show('house', ceilingOf(this.floors, storey));
  }

  /** A click on the doll's house. */
  private goTo(x: number, y: number): void {
    const [from, along] = this.view.rayAt(x, y);
    const at = this.walker.floor.hit(from, along, ceilingOf(this.floors, this.storey));
    if (!at) return;
    this.walker.place(at);
    say(this.said, 'You stand there now.');
  }

  /** For fingers, and for those who know no keys. */
  private makePad(): HTMLElement {
    const one = (name: string, sign: string, action: Action) =>
      button(sign, () => this.controls.act(action), { 'aria-label': name, title: name });
    return make('div', { class: 'roam-pad', role: 'group', 'aria-label': 'Actions of an agent' },
      one('Turn left by 15 degrees', '↰', 'left'), one('A step forward', '↑', 'forward'), one('Turn right by 15 degrees', '↱', 'right'));
  }

  private aboutEpisode(): HTMLElement[] {
    if (!this.episode) return [];
    const { instruction, language, path } = this.episode;
    const text = make('p', { class: 'instruction' }, instruction);
    if (language) text.lang = language;
    return [text, make('p', { class: 'note' }, path
      ? 'The reference path is blue, from the green pole to the red one; your own walk is purple.' : 'The goal of this one is hidden.')];
  }

  private restart(): void {
    const [at, looking] = beginning(this.walker.floor, this.scan, undefined, this.episode);
    this.walker.place(at, looking);
  }

  private tell(action: Action, touched: boolean): void {
    if (action === 'forward') say(this.said, touched ? `A wall, after ${this.walker.length.toFixed(2)} m` : `${this.walker.length.toFixed(2)} m`);
  }

  private follow(): void {
    const { position, heading, elevation, length, collisions, actions } = this.walker;
    const near = nearestViewpoint(this.scan, position);
    this.panorama.hidden = near === undefined;
    if (near !== undefined) {
      const place = { scan: this.scan.scan, viewpoint: this.scan.viewpoints[near]!.id, heading, elevation };
      this.panorama.href = `/view${formatLink(place)}`;
    }
    const goal = this.episode?.goals?.[0];
    const away = goal ? Math.hypot(...goal.position.map((x, k) => x - position[k]!)) : 0;
    this.numbers.replaceChildren(facts([
      ['Walked', `${length.toFixed(1)} m`], ['Actions', String(actions)], ['Collisions', String(collisions)],
      ...(goal ? [['Goal', `${away.toFixed(1)} m away in a straight line${away <= goal.radius ? `: within ${goal.radius} m` : ''}`] as const] : []),
    ]));
    if (this.view.mode === 'house') {
      const storey = storeyAt(this.floors, position[2]);
      if (storey !== this.storey) this.showStorey(storey);
    }
    clearTimeout(this.timer); // browsers refuse a new address for every frame of a drag
    this.timer = window.setTimeout(() => history.replaceState(null, '',
      formatLink({ scan: this.scan.scan, viewpoint: formatPoint(position), heading, elevation })), 200);
  }
}

run(async () => {
  const main = byId('main');
  const episode = await findEpisode();
  const place = parseLink(location.hash);
  const name = place?.scan ?? episode?.scan;
  if (!name) throw new Error('The address names no building: /roam#scan');
  main.replaceChildren(make('div', { class: 'view' }, loading()));
  const [scan, data] = await Promise.all([api.scan(name), api.call<FloorData>(`${pathOf(name)}/floor`)]);
  addHeader(scan);
  document.title = `${name} · Enfilade`;
  const floor = new Floor(data);
  const walker = new Walker(floor, ...beginning(floor, scan, place, episode));
  const view = await RoamView.open(walker, parseGlb(await fetchMesh(name)));
  const map = new RoamMap(walker, scan);
  if (episode) {
    const goals = (episode.goals ?? []).map(({ position }) => position);
    view.marks.setEpisode(episode.start, episode.path ?? [], goals);
    map.setEpisode(episode.start, episode.path ?? [], goals);
  }
  new Page(scan, walker, view, episode).build(main, map);
  window.roaming = { walker, view };
  addEventListener('hashchange', () => location.reload());
  map.setPlan(await api.plan(name).catch(() => ({ storeys: [], rooms: [] })));
}, 'This building cannot be walked in');
