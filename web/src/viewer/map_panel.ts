/** The map with its storeys, its rooms to go to, and the building as a doll's house. */
import { pictured, type Plan, roomCentre } from '../scan/scan.ts';
import type { DollsHouse } from './dolls_house.ts';
import type { MiniMap } from './mini_map.ts';
import { storeyName } from './storey_name.ts';
import type { Viewer } from './viewer.ts';

const button = (text: string, act: () => void): HTMLButtonElement => {
  const made = document.createElement('button');
  made.type = 'button';
  made.textContent = text;
  made.addEventListener('click', act);
  return made;
};

/** Of several buttons the one that is on says so. */
const choose = (buttons: readonly HTMLButtonElement[], on: number): void =>
  buttons.forEach((one, k) => one.setAttribute('aria-pressed', String(k === on)));

const group = (label: string, ...buttons: readonly HTMLElement[]): HTMLElement => {
  const made = document.createElement('div');
  made.className = 'enfilade-choice';
  made.setAttribute('role', 'group');
  made.setAttribute('aria-label', label);
  made.append(...buttons);
  return made;
};

export class MapPanel {
  readonly element = document.createElement('div');
  private readonly viewer: Viewer;
  private readonly map: MiniMap;
  private readonly bar = document.createElement('div');
  private readonly picture = document.createElement('div');
  private readonly views: readonly HTMLButtonElement[];
  private readonly storeys: readonly HTMLButtonElement[];
  private plan: Plan | undefined;
  private house: DollsHouse | undefined;

  constructor(viewer: Viewer, map: MiniMap) {
    this.viewer = viewer;
    this.map = map;
    this.element.className = 'enfilade-map-panel';
    this.bar.className = 'enfilade-map-bar';
    this.picture.className = 'enfilade-map-picture';
    this.picture.append(map.element);
    this.views = [button('Plan', () => this.showMap()), button('Doll’s house', () => void this.showHouse())];
    this.storeys = viewer.scan.storeys.map((_, k) => button(String(k), () => map.showStorey(k)));
    this.storeys.forEach((one, k) => one.setAttribute('aria-label', storeyName(k)));
    if (this.storeys.length > 1) this.bar.append(group('Storeys', ...this.storeys));
    this.element.append(this.picture, this.bar);
    map.onStorey((storey) => {
      choose(this.storeys, storey);
      this.house?.showStorey(storey);
    });
    choose(this.storeys, map.storey);
    choose(this.views, 0);
    this.bar.hidden = this.bar.childElementCount === 0;
  }

  /** What is known of rooms and walls. */
  setPlan(plan: Plan): void {
    this.plan = plan;
    this.map.setPlan(plan);
    const rooms = plan.rooms.map((room) => pictured(this.viewer.scan, room)).filter(({ name, viewpoints }) => name && viewpoints.length > 0);
    if (rooms.length > 0) this.bar.append(this.roomList(rooms));
    if (plan.rooms.length > 0) this.bar.prepend(group('Map', ...this.views));
    this.bar.hidden = this.bar.childElementCount === 0;
  }

  private showMap(): void {
    choose(this.views, 0);
    this.picture.replaceChildren(this.map.element);
  }

  private async showHouse(): Promise<void> {
    choose(this.views, 1);
    if (!this.house) {
      const { DollsHouse: House } = await import('./dolls_house.ts'); // most visitors never ask for it
      this.house ??= new House(this.viewer, this.plan!);
      this.house.showStorey(this.map.storey);
    }
    if (this.views[1]!.ariaPressed !== 'true') return; // asked for the plan again meanwhile
    this.picture.replaceChildren(this.house.element);
    this.house.draw();
  }

  private roomList(rooms: Plan['rooms']): HTMLElement {
    const list = document.createElement('select');
    list.setAttribute('aria-label', 'Go to a room');
    list.append(new Option('Go to a room', ''));
    const several = this.storeys.length > 1;
    [...rooms].sort((a, b) => a.storey - b.storey || a.name.localeCompare(b.name)).forEach((room) => {
      list.append(new Option(several ? `${room.name}, ${storeyName(room.storey).toLowerCase()}` : room.name,
        String(roomCentre(this.viewer.scan, room))));
    });
    list.addEventListener('change', () => {
      if (list.value !== '') void this.viewer.go(Number(list.value), true);
      list.value = '';
    });
    return list;
  }
}
