/** What the colours of the layer mean that is laid over the picture. */
import type { Layer } from '../scan/scan.ts';
import type { Api } from '../server/api.ts';
import type { Viewer } from './viewer.ts';

/** As many as fit beside a picture; the rest are small. */
const mostClasses = 12;

export class Legend {
  readonly element = document.createElement('div');
  private readonly viewer: Viewer;
  private readonly api: Api;
  private layer: Layer = 'colour';
  private shown = '';

  constructor(viewer: Viewer, api: Api) {
    this.viewer = viewer;
    this.api = api;
    this.element.className = 'enfilade-legend';
    this.element.setAttribute('role', 'region');
    this.element.setAttribute('aria-label', 'Legend');
    this.element.tabIndex = 0; // on a small screen it scrolls
    this.element.hidden = true;
    viewer.onChange(() => void this.update());
  }

  /** The layer that is laid over; of colours there is no legend. */
  show(layer: Layer): void {
    this.layer = layer;
    void this.update();
  }

  private async update(): Promise<void> {
    const { id } = this.viewer.scan.viewpoints[this.viewer.pose.viewpoint]!;
    const wanted = this.layer === 'colour' ? '' : `${this.layer}/${id}`;
    if (wanted === this.shown) return;
    this.shown = wanted;
    if (wanted === '') {
      this.element.hidden = true;
      return;
    }
    const legends = await this.api.legends(this.viewer.scan.scan, id).catch(() => undefined);
    if (wanted !== this.shown) return; // one has walked on
    const rows = this.layer === 'depth' ? depth(legends?.depth ?? null) : classes(legends?.classes ?? null);
    this.element.replaceChildren(...rows);
    this.element.hidden = rows.length === 0;
  }
}

type Legends = Awaited<ReturnType<Api['legends']>>;

function element(name: string, className: string, ...children: (Node | string)[]): HTMLElement {
  const made = document.createElement(name);
  made.className = className;
  made.append(...children);
  return made;
}

function depth(legend: Legends['depth']): HTMLElement[] {
  if (!legend) return [];
  const bar = element('div', 'bar');
  bar.style.background = `linear-gradient(to right, ${legend.colours.join(', ')})`;
  return [element('p', 'title', 'Distance from the eye'), bar,
    element('div', 'ends', element('span', '', `${legend.nearest.toFixed(1)} m or less`),
      element('span', '', `${legend.farthest.toFixed(1)} m or more`))];
}

function classes(legend: Legends['classes']): HTMLElement[] {
  if (!legend || legend.length === 0) return [];
  const list = element('ul', 'classes', ...legend.slice(0, mostClasses).map(({ name, colour }) => {
    const swatch = element('i', '');
    swatch.style.background = colour;
    return element('li', '', swatch, name.replaceAll('_', ' '));
  }));
  const more = legend.length - mostClasses;
  return [element('p', 'title', 'Classes'), list, ...(more > 0 ? [element('p', 'more', `and ${more} smaller ones`)] : [])];
}
