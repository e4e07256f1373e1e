/** Keys, mouse and touch: for walking, and for the building from outside. */
import { degrees } from '../geometry/geometry.ts';
import type { RoamView } from './roam_view.ts';
import type { Action, Walker } from './walker.ts';

/** Smooth walking, as people stroll indoors: metres and radians per second. */
const speed = 1.3;
const turning = degrees(90);
const orbitStep = degrees(15);
/** Of a drag from outside: radians a pixel. */
const orbitPixel = 0.008;
const zoomStep = 1.1;
const clickSlack = 6;

export const keyHelp = 'Arrow keys act as an agent does: ↑ a step of 0.25 m, ← and → a turn of 15°. W, A, S and D walk smoothly, Q and E turn, Page Up and Page Down look up and down.';
export const houseHelp = 'Arrow keys turn the building, plus and minus zoom.';

const stepKeys: Readonly<Record<string, Action>> = { ArrowUp: 'forward', ArrowLeft: 'left', ArrowRight: 'right', PageUp: 'up', PageDown: 'down' };
/** Ahead, to the right, turning to the right. */
const freeKeys: Readonly<Record<string, readonly [number, number, number]>> = {
  KeyW: [1, 0, 0], KeyS: [-1, 0, 0], KeyA: [0, -1, 0], KeyD: [0, 1, 0], KeyQ: [0, 0, -1], KeyE: [0, 0, 1],
};

export class RoamControls {
  private readonly view: RoamView;
  private readonly walker: Walker;
  private readonly onAct: (action: Action, touched: boolean) => void;
  private readonly onFloor: (x: number, y: number) => void;
  private readonly held = new Set<string>();
  private readonly pointers = new Map<number, { readonly x: number; readonly y: number }>();
  private moved = 0;
  private before = 0;
  private frame = 0;

  /** @param onFloor a click on the building from outside, pixels of the canvas */
  constructor(view: RoamView, walker: Walker, onAct: (action: Action, touched: boolean) => void, onFloor: (x: number, y: number) => void) {
    [this.view, this.walker, this.onAct, this.onFloor] = [view, walker, onAct, onFloor];
    const { canvas } = view;
    canvas.setAttribute('role', 'application');
    canvas.addEventListener('keydown', (event) => this.press(event));
    canvas.addEventListener('keyup', (event) => this.held.delete(event.code));
    canvas.addEventListener('blur', () => this.held.clear());
    canvas.addEventListener('pointerdown', (event) => {
      canvas.setPointerCapture(event.pointerId);
      canvas.focus({ preventScroll: true });
      this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      this.moved = this.pointers.size > 1 ? Infinity : 0;
    });
    canvas.addEventListener('pointermove', (event) => this.drag(event));
    canvas.addEventListener('pointerup', (event) => this.release(event));
    canvas.addEventListener('pointercancel', (event) => this.pointers.delete(event.pointerId));
    canvas.addEventListener('wheel', (event) => {
      if (this.view.mode !== 'house') return;
      event.preventDefault();
      this.view.zoomBy(zoomStep ** Math.sign(event.deltaY));
    }, { passive: false });
    this.name();
  }

  /** Says what the keys do now. */
  name(): void {
    this.view.canvas.setAttribute('aria-label', this.view.mode === 'inside' ? `The building from within. ${keyHelp}` : `Doll’s house. ${houseHelp}`);
  }

  act(action: Action): void {
    this.onAct(action, this.walker.act(action));
  }

  private press(event: KeyboardEvent): void {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (this.view.mode === 'house') return this.pressOutside(event);
    const step = stepKeys[event.key];
    if (step) this.act(step);
    else if (freeKeys[event.code]) this.hold(event.code);
    else if (event.key !== 'ArrowDown') return; // an agent cannot go backwards; the page is not to scroll either
    event.preventDefault();
  }

  private pressOutside(event: KeyboardEvent): void {
    const actions: Record<string, () => void> = {
      ArrowLeft: () => this.view.orbit(-orbitStep, 0), ArrowRight: () => this.view.orbit(orbitStep, 0),
      ArrowUp: () => this.view.orbit(0, orbitStep), ArrowDown: () => this.view.orbit(0, -orbitStep),
      '+': () => this.view.zoomBy(1 / zoomStep), '=': () => this.view.zoomBy(1 / zoomStep), '-': () => this.view.zoomBy(zoomStep),
    };
    const action = actions[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  }

  private hold(code: string): void {
    this.held.add(code);
    if (this.held.size > 1 || this.frame !== 0) return;
    this.before = performance.now();
    this.frame = requestAnimationFrame((now) => this.stroll(now));
  }

  private stroll(now: number): void {
    this.frame = 0;
    if (this.held.size === 0 || this.view.mode !== 'inside') return;
    const seconds = Math.min(Math.max((now - this.before) / 1000, 0), 0.15); // no leap after a pause
    this.before = now;
    let [ahead, right, turn] = [0, 0, 0];
    for (const code of this.held) {
      const [a, r, t] = freeKeys[code]!;
      [ahead, right, turn] = [ahead + a, right + r, turn + t];
    }
    if (turn !== 0) this.walker.look(this.walker.heading + turn * turning * seconds, this.walker.elevation);
    const size = Math.hypot(ahead, right);
    if (size > 0) this.walker.glide((ahead / size) * speed * seconds, (right / size) * speed * seconds);
    this.frame = requestAnimationFrame((next) => this.stroll(next));
  }

  private drag(event: PointerEvent): void {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const [dx, dy] = [event.clientX - before.x, event.clientY - before.y];
    const now = { x: event.clientX, y: event.clientY };
    if (this.pointers.size > 1) this.pinch(event.pointerId, before, now);
    else if (this.view.mode === 'house') this.view.orbit(dx * orbitPixel, dy * orbitPixel);
    else this.walker.look(this.walker.heading - dx * this.view.perPixel, this.walker.elevation + dy * this.view.perPixel);
    this.moved += Math.hypot(dx, dy);
    this.pointers.set(event.pointerId, now);
  }

  private pinch(id: number, before: { x: number; y: number }, now: { x: number; y: number }): void {
    if (this.view.mode !== 'house') return;
    const other = [...this.pointers].find(([one]) => one !== id)![1];
    const apart = (p: { x: number; y: number }) => Math.max(Math.hypot(p.x - other.x, p.y - other.y), 1);
    this.view.zoomBy(apart(before) / apart(now));
  }

  private release(event: PointerEvent): void {
    if (!this.pointers.delete(event.pointerId) || this.moved > clickSlack || this.view.mode !== 'house') return;
    const box = this.view.canvas.getBoundingClientRect();
    this.onFloor(event.clientX - box.left, event.clientY - box.top);
  }
}
