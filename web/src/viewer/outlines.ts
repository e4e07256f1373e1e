/** Boxes around objects in the view, and a mark where the user points. */
import { make } from '../elements/page.ts';
import { type Direction, toDegrees } from '../geometry/geometry.ts';
import { mayBeSeen, rimInView } from './outline_layer.ts';
import type { Viewer } from './viewer.ts';

const svgNamespace = 'http://www.w3.org/2000/svg';

/** Corners as heading and elevation, radians. */
type Corners = readonly (readonly [number, number])[];

/** Lies over a viewer's picture and turns with it. Says in words, too, where the object is. */
export class Outlines {
  /** For screen readers: "To the left." */
  readonly said = document.createElement('p');
  /** Turns to the object; hidden while it is in view, or not seen from here. */
  readonly button = make('button', { type: 'button', hidden: '' }, 'Look at it');
  private readonly viewer: Viewer;
  private readonly svg = document.createElementNS(svgNamespace, 'svg');
  private readonly box = document.createElementNS(svgNamespace, 'polygon');
  private readonly mark = document.createElementNS(svgNamespace, 'circle');
  private readonly ends: () => void;
  private readonly resizes = new ResizeObserver(() => this.show());
  private readonly boxes: ReadonlyMap<number, Corners>;
  private point: (Direction & { readonly viewpoint: number }) | undefined;

  /** @param boxes by viewpoint */
  constructor(viewer: Viewer, boxes: ReadonlyMap<number, Corners> = new Map()) {
    this.viewer = viewer;
    this.boxes = boxes;
    this.svg.classList.add('enfilade-outlines');
    this.svg.setAttribute('aria-hidden', 'true');
    this.mark.setAttribute('r', '14');
    this.svg.append(this.box, this.mark);
    viewer.element.append(this.svg);
    this.said.setAttribute('role', 'status');
    this.button.addEventListener('click', () => {
      this.lookAt();
      viewer.element.querySelector('canvas')?.focus(); // the button is gone
    });
    this.ends = viewer.onChange(() => this.show());
    this.resizes.observe(viewer.element);
    this.show();
  }

  dispose(): void {
    this.ends();
    this.resizes.disconnect();
    this.svg.remove();
  }

  /** Where the user points, and from where; undefined: nowhere. */
  setPoint(point: Direction | undefined, viewpoint = this.viewer.pose.viewpoint): void {
    this.point = point && { heading: point.heading, elevation: point.elevation, viewpoint };
    this.show();
  }

  /** Turns to the object, if it is seen from here. */
  lookAt(): void {
    const corners = this.boxes.get(this.viewer.pose.viewpoint);
    if (!corners) return;
    const elevations = corners.map(([, elevation]) => elevation);
    this.viewer.look(this.viewer.pose.heading + this.turn(corners), (Math.min(...elevations) + Math.max(...elevations)) / 2);
  }

  private show(): void {
    const { pose, view, onTheWay } = this.viewer;
    const corners = onTheWay ? undefined : this.boxes.get(pose.viewpoint);
    const points = rimInView(corners?.flat() ?? [], view, pose);
    this.box.toggleAttribute('hidden', !mayBeSeen(points, view));
    this.box.setAttribute('points', points.map(([x, y]) => `${x.toFixed(1)},${y.toFixed(1)}`).join(' '));
    const [mark] = this.point && this.point.viewpoint === pose.viewpoint && !onTheWay
      ? rimInView([this.point.heading, this.point.elevation], view, pose) : [];
    this.mark.toggleAttribute('hidden', !mark);
    if (mark) {
      this.mark.setAttribute('cx', mark[0].toFixed(1));
      this.mark.setAttribute('cy', mark[1].toFixed(1));
    }
    this.tell(corners, points);
  }

  private tell(corners: Corners | undefined, points: readonly (readonly [number, number])[]): void {
    if (this.boxes.size === 0) return;
    let text = 'The object is not seen from here.';
    this.button.hidden = !corners || mayBeSeen(points, this.viewer.view);
    if (corners) {
      const turn = Math.round(toDegrees(this.turn(corners)) / 10) * 10;
      text = mayBeSeen(points, this.viewer.view) ? 'The object is in the view, with an orange frame.'
        : `Turn ${turn < 0 ? 'left' : 'right'} to see the object, by about ${Math.abs(turn)} degrees.`;
    }
    if (this.said.textContent !== text) this.said.textContent = text;
  }

  private turn(corners: Corners): number {
    const [x, y] = corners.reduce(([a, b], [h]) => [a + Math.sin(h), b + Math.cos(h)], [0, 0]);
    const difference = Math.atan2(x, y) - this.viewer.pose.heading;
    return Math.atan2(Math.sin(difference), Math.cos(difference));
  }
}
