/** The rooms of a building with a picture of each: where a click goes. */
import { counted, make } from '../elements/page.ts';
import { pictured, type Plan, type Room, roomCentre } from '../scan/scan.ts';
import type { Api } from '../server/api.ts';
import { storeyName } from './storey_name.ts';
import type { Viewer } from './viewer.ts';

/** More than these are folded. */
const shownAtOnce = 6;

interface Card {
  readonly room: Room;
  /** The viewpoint with pictures that stands nearest to the room's middle. */
  readonly viewpoint: number;
}

function cardsOf({ scan }: Viewer, plan: Plan): Card[] {
  return plan.rooms.map((room) => pictured(scan, room))
    .filter(({ name, viewpoints }) => name !== '' && viewpoints.length > 0)
    .sort((a, b) => a.storey - b.storey || a.name.localeCompare(b.name))
    .map((room) => ({ room, viewpoint: roomCentre(scan, room) }));
}

/** Nothing where no room has a name and pictures. The room in which one stands is marked. */
export function roomCards(viewer: Viewer, plan: Plan, api: Api): HTMLElement | undefined {
  const cards = cardsOf(viewer, plan);
  if (cards.length === 0) return undefined;
  const several = viewer.scan.storeys.length > 1;
  const buttons = cards.map(({ room, viewpoint }) => {
    const src = api.thumbnail(viewer.scan.scan, viewer.scan.viewpoints[viewpoint]!.id);
    const picture = make('img', { src, alt: '', loading: 'lazy', width: '320', height: '200' });
    const text = several ? `${room.name}, ${storeyName(room.storey).toLowerCase()}` : room.name;
    const button = make('button', { type: 'button' }, picture, make('span', {}, text));
    button.addEventListener('click', () => void viewer.go(viewpoint, true));
    return button;
  });
  const list = (some: readonly HTMLElement[]) => make('ul', { class: 'room-cards' }, ...some.map((button) => make('li', {}, button)));
  const more = buttons.slice(shownAtOnce);
  const mark = () => cards.forEach(({ room }, k) => {
    if (room.viewpoints.includes(viewer.pose.viewpoint)) buttons[k]!.setAttribute('aria-current', 'location');
    else buttons[k]!.removeAttribute('aria-current');
  });
  viewer.onChange(mark);
  mark();
  return make('section', { 'aria-label': 'Rooms' }, make('h2', {}, 'Rooms'), list(buttons.slice(0, shownAtOnce)),
    ...(more.length > 0 ? [make('details', {}, make('summary', {}, counted(more.length, 'more room')), list(more))] : []));
}
