/** Pieces of an instruction in a list, and the viewpoints that they describe on the map. */
import { make } from '../elements/page.ts';
import type { MiniMap, Moment, Viewer } from '../viewer/enfilade-viewer.ts';
import type { Part } from './episode.ts';
import { partsAt, pieceText, placesText } from './parts.ts';

export class PartList {
  readonly element: HTMLElement;
  private readonly map: MiniMap;
  private readonly parts: readonly Part[];
  private readonly path: readonly number[];
  private readonly items: readonly HTMLElement[];
  /** Pieces that the fly-through is at. */
  private followed: readonly number[] = [];
  /** The piece that has the pointer or the focus. */
  private chosen: number | undefined;

  /** @param path viewpoints; without them the pieces have no places */
  constructor(viewer: Viewer, map: MiniMap, parts: readonly Part[], path: readonly number[]) {
    [this.map, this.parts, this.path] = [map, parts, path];
    this.items = parts.map((part, k) => this.item(viewer, part, k));
    this.element = make('ol', { class: 'parts' }, ...this.items);
  }

  /** Marks what a moment of the fly-through is about. */
  follow(moment: Pick<Moment, 'from' | 'to'>): void {
    this.followed = partsAt(this.parts, this.path, moment);
    this.mark();
  }

  /** Words that lead to where they begin, and mark their viewpoints while they are pointed at. */
  private item(viewer: Viewer, { words, places }: Part, k: number): HTMLElement {
    const at = places && this.path[places[0]];
    if (!places || at === undefined) return make('li', {}, pieceText(words));
    const button = make('button', { type: 'button', class: 'quiet' }, pieceText(words));
    button.addEventListener('click', () => void viewer.go(at));
    const choose = (part: number | undefined) => () => {
      if (part === undefined && this.chosen !== k) return; // another one is pointed at by now
      this.chosen = part;
      this.mark();
    };
    for (const event of ['pointerenter', 'focus']) button.addEventListener(event, choose(k));
    for (const event of ['pointerleave', 'blur']) button.addEventListener(event, choose(undefined));
    return make('li', {}, button, ' ', make('span', { class: 'note' }, placesText(places)));
  }

  private mark(): void {
    const shown = this.chosen === undefined ? this.followed : [this.chosen];
    this.items.forEach((item, k) => item.classList.toggle('said', shown.includes(k)));
    this.map.setMarked(shown.flatMap((k) => {
      const places = this.parts[k]!.places;
      return places ? this.path.slice(places[0], places[1] + 1) : [];
    }));
  }
}
