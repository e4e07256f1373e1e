/** Boxes around objects in the view, and a mark where the user points. */
import { type Direction, project, toDegrees, unitVector, type Vec3 } from '../geometry/geometry.ts';
import type { Viewer } from './viewer.ts';

const svgNamespace = 'http://www.w3.org/2000/svg';

/** Corners as heading and elevation, radians. */
type Corners = readonly (readonly [number, number])[];

const origin: Vec3 = [0, 0, 0];

/** Lies over a viewer's picture and turns with it. Says in words, too, where the object is. */
export class Outlines {
  /** For screen readers: "To the left." */
  readonly said = document.createElement('p');
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

  private at(heading: number, elevation: number): readonly [number, number] | undefined {
    return project(this.viewer.view, this.viewer.pose, origin, unitVector({ heading, elevation }));
  }

  private show(): void {
    const { pose, onTheWay } = this.viewer;
    const corners = onTheWay ? undefined : this.boxes.get(pose.viewpoint);
    const points = corners?.map(([heading, elevation]) => this.at(heading, elevation)) ?? [];
    const seen = points.length > 0 && points.every((one) => one !== undefined);
    this.box.toggleAttribute('hidden', !seen);
    this.box.setAttribute('points', seen ? points.map((one) => one!.map((x) => x.toFixed(1)).join()).join(' ') : '');
    const mark = this.point && this.point.viewpoint === pose.viewpoint && !onTheWay && this.at(this.point.heading, this.point.elevation);
    this.mark.toggleAttribute('hidden', !mark);
    if (mark) {
      this.mark.setAttribute('cx', mark[0].toFixed(1));
      this.mark.setAttribute('cy', mark[1].toFixed(1));
    }
    this.tell(corners, points);
  }

  private tell(corners: Corners | undefined, points: readonly (readonly [number, number] | undefined)[]): void {
    if (this.boxes.size === 0) return;
    const { width, height } = this.viewer.view;
    let text = 'The object is not seen from here.';
    if (corners) {
      const inside = points.some((one) => one && one[0] >= 0 && one[0] <= width && one[1] >= 0 && one[1] <= height);
      const turn = Math.round(toDegrees(this.turn(corners)) / 10) * 10;
      text = inside ? 'The object is in the view, with an orange frame.'
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
