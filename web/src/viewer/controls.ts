/** Mouse, fingers and keys of a viewer, and the list of steps for those who use none of them. */
import { counted } from '../elements/page.ts';
import { type Camera, type Direction, degrees, toDegrees, wrapDifference } from '../geometry/geometry.ts';
import type { Step } from '../scan/navigation.ts';

const keyTurn = degrees(10);
const zoomStep = 1.1;
/** A press that moves less than this many pixels is a click. */
const clickSlack = 6;

/** What controls need of the viewer that they steer. */
interface Steered {
  readonly element: HTMLElement;
  readonly pose: Direction & { readonly viewpoint: number; readonly vfov: number };
  readonly view: Camera;
  /** Whether zoom() does anything. */
  readonly zooms: boolean;
  steps(): Step[];
  look(heading: number, elevation: number): void;
  zoom(vfov: number): void;
  go(viewpoint: number): Promise<boolean>;
  /** Goes to the viewpoint that is shown at a point of the canvas, in pixels. */
  goAt(x: number, y: number): void;
  /** Shows where a click there would go; without a point, nothing. Returns whether anywhere. */
  hoverAt(x?: number, y?: number): boolean;
  /** The name of a viewpoint, if it has one that people may know. */
  name(viewpoint: number): string | undefined;
  /** The next viewpoint of a marked path. */
  readonly nextOnPath: number | undefined;
  onChange(listener: () => void): () => void;
}

export const keyHelp = (viewer: Pick<Steered, 'zooms'>): string =>
  `Arrow keys look around,${viewer.zooms ? ' plus and minus zoom,' : ''} Enter goes ahead, 1 to 9 go to the listed places.`;

/** "ahead", "45 degrees to the left". */
export function bearing(relHeading: number): string {
  const angle = Math.round(toDegrees(wrapDifference(relHeading)) / 5) * 5;
  if (angle === 0) return 'ahead';
  if (Math.abs(angle) >= 175) return 'behind';
  return `${Math.abs(angle)}° to the ${angle > 0 ? 'right' : 'left'}`;
}

/** "Viewpoint 7, kitchen. 2 places to go to." Nothing of places where one does not go by oneself. */
export const standing = (viewpoint: number, room: string | undefined, places: number): string =>
  `Viewpoint ${viewpoint}${room ? `, ${room}` : ''}.${places === 0 ? '' : ` ${counted(places, 'place')} to go to.`}`;

export class Controls {
  private readonly viewer: Steered;
  private readonly canvas: HTMLElement;
  private readonly list = document.createElement('ul');
  private readonly said = document.createElement('p');
  private readonly ends = new AbortController();
  private readonly pointers = new Map<number, PointerEvent>();
  private moved = 0;
  private standing = -1;

  constructor(viewer: Steered) {
    this.viewer = viewer;
    this.canvas = viewer.element.querySelector('canvas')!;
    this.label();
    this.listen();
    viewer.onChange(() => this.describe());
  }

  dispose(): void {
    this.ends.abort();
    this.list.parentElement?.remove();
    this.said.remove();
  }

  private label(): void {
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute('role', 'application');
    this.canvas.setAttribute('aria-label', `Panorama. ${keyHelp(this.viewer)}`);
    this.said.className = 'enfilade-said';
    this.said.setAttribute('aria-live', 'polite');
    const nav = document.createElement('nav');
    nav.className = 'enfilade-steps';
    nav.setAttribute('aria-label', 'Places to go to');
    nav.append(this.list);
    this.viewer.element.append(nav, this.said);
  }

  private listen(): void {
    const { canvas } = this;
    const { signal } = this.ends;
    canvas.addEventListener('pointerdown', (e) => this.press(e), { signal });
    canvas.addEventListener('pointermove', (e) => this.drag(e), { signal });
    canvas.addEventListener('pointerleave', () => this.hover(), { signal });
    canvas.addEventListener('pointerup', (e) => this.release(e, true), { signal });
    canvas.addEventListener('pointercancel', (e) => this.release(e, false), { signal });
    canvas.addEventListener('keydown', (e) => this.key(e), { signal });
    canvas.addEventListener(
      'wheel',
      (e) => {
        e.preventDefault();
        this.viewer.zoom(this.viewer.pose.vfov * zoomStep ** Math.sign(e.deltaY));
      },
      { signal, passive: false },
    );
  }

  private press(event: PointerEvent): void {
    this.canvas.setPointerCapture(event.pointerId);
    this.canvas.focus({ preventScroll: true });
    this.pointers.set(event.pointerId, event);
    this.moved = this.pointers.size > 1 ? Infinity : 0;
  }

  // The point under the finger stays under it, in the middle of the picture at least.
  private drag(event: PointerEvent): void {
    const before = this.pointers.get(event.pointerId);
    if (!before) return event.pointerType === 'mouse' ? this.hover(event) : undefined;
    if (this.moved > clickSlack) this.hover();
    const [dx, dy] = [event.clientX - before.clientX, event.clientY - before.clientY];
    const { heading, elevation, vfov } = this.viewer.pose;
    if (this.pointers.size === 1) {
      this.moved += Math.hypot(dx, dy);
      const perPixel = (2 * Math.tan(vfov / 2)) / this.viewer.view.height;
      this.viewer.look(heading - dx * perPixel, elevation + dy * perPixel);
    } else {
      const other = [...this.pointers.values()].find((p) => p.pointerId !== event.pointerId)!;
      const apart = (p: PointerEvent) =>
        Math.hypot(p.clientX - other.clientX, p.clientY - other.clientY);
      this.viewer.zoom((vfov * Math.max(apart(before), 1)) / Math.max(apart(event), 1));
    }
    this.pointers.set(event.pointerId, event);
  }

  private hover(event?: PointerEvent): void {
    const box = this.canvas.getBoundingClientRect();
    const anywhere = event ? this.viewer.hoverAt(event.clientX - box.left, event.clientY - box.top) : this.viewer.hoverAt();
    this.canvas.classList.toggle('enfilade-lands', anywhere);
  }

  private release(event: PointerEvent, click: boolean): void {
    if (!this.pointers.delete(event.pointerId) || !click || this.moved > clickSlack) return;
    const box = this.canvas.getBoundingClientRect();
    this.viewer.goAt(event.clientX - box.left, event.clientY - box.top);
  }

  private key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const { heading, elevation, vfov } = this.viewer.pose;
    const steps = this.viewer.steps();
    const actions: Record<string, () => void> = {
      ArrowLeft: () => this.viewer.look(heading - keyTurn, elevation),
      ArrowRight: () => this.viewer.look(heading + keyTurn, elevation),
      ArrowUp: () => this.viewer.look(heading, elevation + keyTurn),
      ArrowDown: () => this.viewer.look(heading, elevation - keyTurn),
      '+': () => this.viewer.zoom(vfov / zoomStep),
      '=': () => this.viewer.zoom(vfov / zoomStep),
      '-': () => this.viewer.zoom(vfov * zoomStep),
      Enter: () => steps[0] && void this.viewer.go(steps[0].viewpoint),
      ' ': () => steps[0] && void this.viewer.go(steps[0].viewpoint),
    };
    const digit = /^[1-9]$/.test(event.key) ? steps[Number(event.key) - 1] : undefined;
    const action = digit ? () => void this.viewer.go(digit.viewpoint) : actions[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  }

  /** The list anew; what is said only after a step, not with every turn. */
  private describe(): void {
    const steps = this.viewer.steps();
    const { viewpoint } = this.viewer.pose;
    const focused = [...this.list.children].findIndex((li) => li.contains(document.activeElement));
    this.list.replaceChildren(
      ...steps.map((step, k) => {
        const button = document.createElement('button');
        button.type = 'button';
        const name = this.viewer.name(step.viewpoint);
        button.textContent = `${k + 1}: ${bearing(step.relHeading)}, ${step.distance.toFixed(1)} m` +
          (name ? `, ${name}` : '') + (step.viewpoint === this.viewer.nextOnPath ? ', on the path' : '');
        button.addEventListener('click', () => void this.viewer.go(step.viewpoint));
        const item = document.createElement('li');
        item.append(button);
        return item;
      }),
    );
    if (focused >= 0) {
      const at = this.list.children[Math.min(focused, steps.length - 1)];
      at?.querySelector('button')?.focus();
    }
    if (viewpoint === this.standing) return;
    this.standing = viewpoint;
    this.said.textContent = standing(viewpoint, this.viewer.name(viewpoint), steps.length);
  }
}
