/** Going along a path from place to place. */
import { directionTo } from '../geometry/geometry.ts';
import { make } from '../elements/page.ts';
import type { Viewer } from '../viewer/viewer.ts';
import { lookedAround, type Looks } from './looks.ts';

export class Tour {
  readonly element = make('div', { class: 'tour', role: 'group', 'aria-label': 'Along the path' });
  private readonly viewer: Viewer;
  private readonly path: readonly number[];
  private readonly looks: Looks;
  private readonly moved: () => void;
  private readonly arrived: () => void;
  private readonly dots = make('span', { class: 'dots', 'aria-hidden': 'true' });
  private readonly said = make('span', { role: 'status' });
  private readonly back = this.button('◀ Previous', 'Previous along the path', -1);
  private readonly on = this.button('Next ▶', 'Next along the path', 1);

  /**
   * @param moved is called when a button was pressed: a fly-through should stop then
   * @param arrived is called when a button has led to the path's end
   */
  constructor(viewer: Viewer, path: readonly number[], looks: Looks, moved: () => void, arrived: () => void = () => {}) {
    this.viewer = viewer;
    this.path = path;
    this.looks = looks;
    this.moved = moved;
    this.arrived = arrived;
    this.element.append(this.back, this.dots, this.on, this.said);
    viewer.onChange(() => this.show());
    this.show();
  }

  private get place(): number {
    return this.path.indexOf(this.viewer.pose.viewpoint);
  }

  private button(text: string, label: string, by: number): HTMLButtonElement {
    const button = make('button', { type: 'button', 'aria-label': label }, text);
    button.addEventListener('click', () => void this.step(by));
    return button;
  }

  private async step(by: number): Promise<void> {
    this.moved();
    const to = this.place + by;
    const viewpoint = this.path[to];
    if (viewpoint === undefined || !(await this.viewer.go(viewpoint))) return;
    const ahead = this.path[to + 1];
    if (ahead === undefined) return this.arrived();
    const at = (v: number) => this.viewer.scan.viewpoints[v]!.position;
    this.viewer.look(directionTo(at(viewpoint), at(ahead)).heading, this.viewer.pose.elevation); // as on a walk along it
  }

  private show(): void {
    const { place } = this;
    this.back.ariaDisabled = String(place <= 0); // not disabled, which would take the focus away
    this.on.ariaDisabled = String(place >= this.path.length - 1);
    const names = this.path.map((v, k) => `${k === place ? 'here' : ''} ${this.looks.around(v) ? 'seen' : ''}`);
    const key = names.join();
    if (this.dots.dataset['shown'] === key) return; // poses come with every frame
    this.dots.dataset['shown'] = key;
    this.dots.replaceChildren(...names.map((name) => make('i', { class: name.trim() })));
    const where = place === 0 ? ', the start' : place === this.path.length - 1 ? ', the goal' : '';
    const seen = this.path.filter((v) => this.looks.around(v)).length;
    this.said.textContent = `Place ${place + 1} of ${this.path.length}${where}. ${lookedAround(seen, this.path.length)}`;
  }
}
