/** Finding an object by its description: workers walk as for an instruction, and point at it in the end. */
import { action } from '../elements/forms.ts';
import { type Direction, wrapHeading } from '../geometry/geometry.ts';
import { make } from '../elements/page.ts';
import { Outlines } from '../viewer/enfilade-viewer.ts';
import { WalkTask } from './walk_task.ts';

/** Radians by which an arrow key moves the mark. */
const nudge = Math.PI / 90;
const nudges: Readonly<Record<string, readonly [number, number]>> = {
  ArrowLeft: [-nudge, 0], ArrowRight: [nudge, 0], ArrowUp: [0, nudge], ArrowDown: [0, -nudge],
};

export class FindTask extends WalkTask {
  private overlay: Outlines | undefined;
  private point: { readonly viewpoint: string; readonly direction: Direction } | undefined;
  private readonly yes = action('Yes, this is the object', this.said, () => this.submit(), { class: 'main' });
  private pointing = false;

  override dispose(): void {
    this.overlay?.dispose();
    super.dispose();
  }

  /** Pointing takes a mark, and then a press. */
  protected override ask(sure: boolean): void {
    if (this.pointing && sure) return;
    if (this.point && this.point.viewpoint !== this.here) this.mark(undefined);
    if (this.pointing && this.point === undefined && !sure) this.yes.ariaDisabled = 'true';
    if (!sure && !this.pointing) {
      this.stop.textContent = 'I see the object';
      return this.sure.replaceChildren(make('p', {}, this.stop));
    }
    if (!sure) return; // one goes on walking with the mark in hand
    this.begin();
  }

  private begin(): void {
    this.pointing = true;
    this.overlay ??= new Outlines(this.viewer);
    this.viewer.onPick((direction) => this.mark(direction));
    const middle = make('button', { type: 'button' }, 'Point at the middle');
    middle.addEventListener('click', () => {
      this.mark(this.viewer.pose);
      middle.focus();
    });
    middle.addEventListener('keydown', (event) => this.move(event));
    const no = make('button', { type: 'button' }, 'Keep walking');
    no.addEventListener('click', () => {
      this.end();
      this.stop.focus();
    });
    this.yes.ariaDisabled = 'true';
    this.sure.replaceChildren(
      make('p', {}, 'Click or tap on the object in the picture; a ring marks the place.'),
      make('p', { class: 'note' }, 'By keys: turn until it is in the middle, and press "Point at the middle"; there the arrow keys move the ring.'),
      make('p', { class: 'buttons' }, middle, this.yes, no));
    middle.focus();
  }

  private end(): void {
    this.pointing = false;
    this.viewer.onPick(undefined);
    this.mark(undefined);
    this.ask(false);
  }

  private mark(direction: Direction | undefined): void {
    this.point = direction && { viewpoint: this.here, direction: { heading: wrapHeading(direction.heading), elevation: direction.elevation } };
    this.overlay?.setPoint(this.point?.direction);
    this.yes.ariaDisabled = this.point ? null : 'true';
  }

  private move(event: KeyboardEvent): void {
    const by = nudges[event.key];
    if (!by || !this.point) return;
    event.preventDefault();
    const { heading, elevation } = this.point.direction;
    this.mark({ heading: heading + by[0], elevation: Math.min(Math.max(elevation + by[1], -Math.PI / 2), Math.PI / 2) });
  }

  protected override result(): object {
    return { point: this.point!.direction };
  }
}
