/**
 * Continuous walking in a building: `/roam?split=S&id=I#scan/viewpoint/heading/elevation`, or `@x,y,z` in the viewpoint's place.
 * `?view=house` begins with the doll's house.
 */
import { fullScreenButton } from '../elements/full_screen.ts';
import { lacksGraphics } from '../elements/graphics.ts';
import { linkCopier } from '../elements/link_copier.ts';
import { addHeader, byId, facts, loading, make, run, say } from '../elements/page.ts';
import { episodesOf, floorKey } from '../episodes/splits.ts';
import type { Direction, Vec3 } from '../geometry/geometry.ts';
import { houseHelp, keyHelp, mouseHelp, RoamControls } from '../roam/controls.ts';
import { Floor, type FloorData, type FloorPoint } from '../roam/floor.ts';
import { parseGlb } from '../roam/glb.ts';
import { footOf, formatPoint, nearestViewpoint, parsePoint } from '../roam/places.ts';
import { RoamMap } from '../roam/roam_map.ts';
import { type Mode, RoamView } from '../roam/roam_view.ts';
import { ceilingOf, storeyAt } from '../roam/storeys.ts';
import { type Action, Walker } from '../roam/walker.ts';
import { type Plan, type Room, roomCentre, type Scan, viewpointIndex } from '../scan/scan.ts';
import { api, reach } from '../server/api.ts';
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

/** `id` of an episode, or `trajectory`: the first of that path. Throws Error if there is none. */
async function findEpisode(): Promise<ContinuousEpisode | undefined> {
  const split = query.get('split');
  const which = ['id', 'trajectory'].find((name) => query.has(name));
  if (!split || !which) return undefined;
  const wanted = { [which]: query.get(which)!, limit: '1' };
  const { episodes } = await api.call<{ episodes: ContinuousEpisode[] }>(episodesOf(floorKey(split), wanted));
  if (!episodes[0]) throw new Error(`Split ${split} has no continuous episode ${which === 'id' ? '' : 'of path '}${query.get(which)}`);
  return episodes[0];
}

async function fetchMesh(scan: string): Promise<ArrayBuffer> {
  const response = await reach(`${api.base}/api/v1/${pathOf(scan)}/mesh.glb`);
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
  if (place?.viewpoint && !point && named < 0) throw new Error(`${scan.scan} has no viewpoint ${place.viewpoint}`);
  const first = Math.max(scan.viewpoints.findIndex(({ rotation }) => rotation), 0);
  const feet = point ?? (named >= 0 ? footOf(scan, named) : episode?.start ?? footOf(scan, first));
  const at = floor.nearest(feet);
  if (!at) throw new Error(`The floor of ${scan.scan} is empty`);
  const ours = point === undefined && named < 0 ? episode?.heading : undefined;
  return [at, { heading: place?.heading ?? ours ?? floor.openHeading(at), elevation: place?.elevation ?? 0 }];
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
  private readonly map: RoamMap;
  private readonly episode: ContinuousEpisode | undefined;
  private readonly floors: readonly number[];
  private readonly modes: readonly HTMLButtonElement[];
  private readonly storeys: readonly HTMLButtonElement[];
  private readonly storeyChoice: HTMLElement;
  private readonly pad: HTMLElement;
  private readonly enter = make('div', { class: 'roam-pad' }, button('Go in', () => void this.show('inside'), { class: 'main' }));
  private readonly rooms = make('div', { class: 'controls' });
  private readonly help = make('p', { class: 'note keys' });
  private readonly numbers = make('div', { class: 'roam-numbers' });
  private readonly said = make('p', { class: 'enfilade-said', 'aria-live': 'polite' });
  private readonly panorama = make('a', { class: 'button' }, 'Panorama near here');
  private mode: Mode = 'inside';
  private storey: number;
  private addressTimer = 0;
  private numbersTimer = 0;

  constructor(scan: Scan, walker: Walker, view: RoamView, episode: ContinuousEpisode | undefined) {
    [this.scan, this.walker, this.view, this.episode] = [scan, walker, view, episode];
    this.floors = scan.storeys.map(({ floor }) => floor);
    this.storey = storeyAt(this.floors, walker.position[2]);
    this.controls = new RoamControls(view, walker, {
      acted: (action, touched) => this.tell(action, touched),
      floorAt: (x, y) => this.floorAt(x, y),
      chose: (at) => this.place(at, 'You stand there now.'),
    });
    this.map = new RoamMap(walker, scan, (at) => this.place(walker.floor.nearest(at), 'You stand there now.'));
    this.modes = [button('Inside', () => void this.show('inside')), button('Doll’s house', () => void this.show('house'))];
    this.storeys = this.floors.map((_, k) => button(String(k), () => this.showStorey(k), { 'aria-label': storeyName(k) }));
    this.storeyChoice = choice('Storeys', ...this.storeys);
    this.pad = this.makePad();
    if (episode) {
      const goals = (episode.goals ?? []).map(({ position }) => position);
      view.marks.setEpisode(episode.start, episode.path ?? [], goals);
      this.map.setEpisode(episode.start, episode.path ?? [], goals);
    }
    walker.onChange(() => this.follow());
  }

  build(main: HTMLElement): void {
    const { button: share, said } = linkCopier('Share', 'Link to this view', () => new URL(this.address(), location.href).href);
    const tools = make('div', { class: 'view-tools' }, said, choice('View', ...this.modes), this.storeyChoice, share);
    const view = make('div', { class: 'view' }, this.view.element, tools, this.pad, this.enter, this.said);
    const map = make('div', { class: 'map' }, this.map.element);
    const panel = make('div', { class: 'panel' }, make('h1', {}, this.scan.scan), ...this.aboutEpisode(), this.rooms, this.numbers,
      make('p', { class: 'buttons' }, this.panorama, button('Back to the start', () => this.restart())), this.help);
    main.replaceChildren(view, make('aside', { class: 'side' }, map, panel));
    const whole = fullScreenButton(view, map);
    if (whole) tools.append(whole);
    const mode = query.get('view') === 'house' ? 'house' : 'inside';
    this.view.show(mode, ceilingOf(this.floors, this.storey));
    this.become(mode);
    this.showNumbers();
  }

  /** Walls and names on the map, and a list of rooms to go to. */
  setPlan(plan: Plan): void {
    this.map.setPlan(plan);
    const named = plan.rooms.filter(({ name }) => name !== '').sort((a, b) => a.storey - b.storey || a.name.localeCompare(b.name));
    if (named.length === 0) return;
    const several = this.floors.length > 1;
    const list = make('select', { 'aria-label': 'Go to a room' }, new Option('Go to a room', ''),
      ...named.map(({ name, storey }, k) => new Option(several ? `${name}, ${storeyName(storey).toLowerCase()}` : name, String(k))));
    list.addEventListener('change', () => {
      const room = named[Number(list.value)];
      if (list.value !== '' && room) this.place(this.walker.floor.nearest(this.middleOf(room)), `You stand in the ${room.name} now.`);
      list.value = '';
    });
    this.rooms.replaceChildren(list);
  }

  /** By a flight; who chooses again while it flies sees the end of it. */
  private async show(mode: Mode): Promise<void> {
    const { flying } = this.view;
    if (this.mode === mode && !flying) return;
    const focused = this.enter.contains(document.activeElement);
    this.become(mode);
    if (focused) this.view.canvas.focus({ preventScroll: true }); // the button is gone
    if (flying) this.view.show(mode, ceilingOf(this.floors, this.storey));
    else await this.view.fly(mode, ceilingOf(this.floors, this.storey));
    this.controls.name();
  }

  /** All but the picture. */
  private become(mode: Mode): void {
    this.mode = mode;
    this.controls.halt();
    press(this.modes, mode === 'inside' ? 0 : 1);
    this.storeyChoice.hidden = mode === 'inside' || this.storeys.length < 2;
    this.pad.hidden = mode === 'house';
    this.enter.hidden = mode === 'inside';
    this.help.textContent = mode === 'inside' ? `${mouseHelp} ${keyHelp}` : `Drag to turn it; a click on a floor takes you there. ${houseHelp}`;
    this.storey = storeyAt(this.floors, this.walker.position[2]);
    press(this.storeys, this.storey);
    this.controls.name();
    this.writeAddress();
  }

  private showStorey(storey: number): void {
    this.storey = storey;
    press(this.storeys, storey);
    this.view.show('house', ceilingOf(this.floors, storey));
  }

  /** In the doll's house what is pointed at; inside the end of a straight walk towards it. */
  private floorAt(x: number, y: number): FloorPoint | undefined {
    const [from, along] = this.view.rayAt(x, y);
    const { floor, standing } = this.walker;
    if (this.mode === 'house') return floor.hit(from, along, ceilingOf(this.floors, this.storey));
    const to = floor.hit(from, along, from[2])?.position;
    if (!to) return undefined;
    const [dx, dy] = [to[0] - standing.position[0], to[1] - standing.position[1]];
    const away = Math.hypot(dx, dy);
    return away > 0.1 ? floor.ahead(standing, dx / away, dy / away, away).end : undefined;
  }

  /** Puts one there, with the most floor ahead, and shows it from within. */
  private place(at: FloorPoint | undefined, text: string): void {
    if (!at) return;
    this.controls.halt();
    const facing = this.mode === 'house' ? this.view.facing : this.walker.heading;
    this.walker.place(at, { heading: this.walker.floor.openHeading(at, facing), elevation: 0 });
    say(this.said, text);
    if (this.mode === 'house') void this.show('inside');
  }

  private middleOf(room: Room): Vec3 {
    if (room.viewpoints.length > 0) return footOf(this.scan, roomCentre(this.scan, room));
    const mean = (axis: number): number => {
      const values = room.outline.filter((_, k) => k % 2 === axis);
      return values.reduce((a, b) => a + b, 0) / values.length;
    };
    return [mean(0), mean(1), room.floor];
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
      ? 'The reference path is blue, from the green pole to the red one; your trajectory is purple.' : 'The goal of this one is hidden.')];
  }

  private restart(): void {
    const [at, looking] = beginning(this.walker.floor, this.scan, undefined, this.episode);
    this.controls.halt();
    this.walker.place(at, looking);
  }

  private tell(action: Action, touched: boolean): void {
    if (action === 'forward') say(this.said, touched ? `A wall, after ${this.walker.length.toFixed(2)} m` : `${this.walker.length.toFixed(2)} m`);
  }

  private follow(): void {
    if (this.numbersTimer === 0) this.numbersTimer = window.setTimeout(() => this.showNumbers(), 500); // not with every frame
    if (this.mode === 'house') {
      const storey = storeyAt(this.floors, this.walker.position[2]);
      if (storey !== this.storey) this.showStorey(storey);
    }
    this.writeAddress();
  }

  private showNumbers(): void {
    clearTimeout(this.numbersTimer);
    this.numbersTimer = 0;
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
      ['Length', `${length.toFixed(1)} m`], ['Actions', String(actions)], ['Collisions', String(collisions)],
      ...(goal ? [['Goal', `${away.toFixed(1)} m away in a straight line${away <= goal.radius ? `: within ${goal.radius} m` : ''}`] as const] : []),
    ]));
  }

  private address(): string {
    const { position, heading, elevation } = this.walker;
    const now = new URLSearchParams(query);
    if (this.mode === 'house') now.set('view', 'house');
    else now.delete('view');
    const search = now.size > 0 ? `?${now}` : '';
    return location.pathname + search + formatLink({ scan: this.scan.scan, viewpoint: formatPoint(position), heading, elevation });
  }

  private writeAddress(): void {
    clearTimeout(this.addressTimer); // browsers refuse a new address for every frame of a drag
    this.addressTimer = window.setTimeout(() => history.replaceState(null, '', this.address()), 400);
  }
}

run(async () => {
  if (lacksGraphics()) return;
  const main = byId('main');
  const episode = await findEpisode();
  const place = parseLink(location.hash);
  const name = place?.scan ?? episode?.scan;
  if (!name) throw new Error('The address names no building: /roam#scan');
  main.replaceChildren(make('div', { class: 'view' }, loading()), make('aside', { class: 'side' }));
  const [scan, data] = await Promise.all([api.scan(name), api.call<FloorData>(`${pathOf(name)}/floor`)]);
  addHeader(scan);
  document.title = `${name} · Enfilade`;
  const floor = new Floor(data);
  const walker = new Walker(floor, ...beginning(floor, scan, place, episode));
  const view = await RoamView.open(walker, parseGlb(await fetchMesh(name)));
  const page = new Page(scan, walker, view, episode);
  page.build(main);
  window.roaming = { walker, view };
  addEventListener('hashchange', () => location.reload());
  page.setPlan(await api.plan(name).catch(() => ({ storeys: [], rooms: [] })));
}, 'This building cannot be shown');
