/** Where the next viewpoint is, while no ring is in the picture: agents' views are narrow, and many of them show a wall. */
import { make, say } from '../elements/page.ts';
import { degrees, type Direction, directionTo, project } from '../geometry/geometry.ts';
import { navigable, type Step } from '../scan/navigation.ts';
import { floorBelow } from './discs.ts';
import type { Viewer } from './viewer.ts';

type Looking = Pick<Viewer, 'scan' | 'pose' | 'view' | 'steps'>;

interface Elsewhere {
  /** "to the left" */
  readonly where: string;
  /** Looks at it, in the lower part of the picture. */
  readonly look: Direction;
}

const behind = degrees(140);

function isInSight({ scan, pose, view }: Looking, viewpoint: number): boolean {
  const at = project(view, pose, scan.viewpoints[pose.viewpoint]!.position, floorBelow(scan, viewpoint));
  return at !== undefined && at[0] >= 0 && at[0] <= view.width && at[1] >= 0 && at[1] <= view.height;
}

function whereIs({ view }: Looking, { relHeading }: Step, up: boolean): string {
  const half = Math.atan(Math.tan(view.vfov / 2) * (view.width / view.height));
  if (Math.abs(relHeading) <= half) return up ? 'above the picture' : 'below the picture';
  if (Math.abs(relHeading) >= behind) return 'behind you';
  return relHeading > 0 ? 'to the right' : 'to the left';
}

/** The viewpoint that takes the least turn; nothing while a ring is in the picture, or if no edge leads on. */
export function nextElsewhere(viewer: Looking): Elsewhere | undefined {
  const { scan, pose, view } = viewer;
  if (viewer.steps().some(({ viewpoint }) => isInSight(viewer, viewpoint))) return undefined;
  const [nearest] = navigable(scan, pose.viewpoint, pose);
  if (!nearest) return undefined;
  const { heading, elevation } = directionTo(scan.viewpoints[pose.viewpoint]!.position, floorBelow(scan, nearest.viewpoint));
  const margin = view.vfov / 4;
  const level = elevation < -margin ? elevation + margin : elevation > margin ? elevation - margin : 0;
  return { where: whereIs(viewer, nearest, elevation > pose.elevation), look: { heading, elevation: level } };
}

/** The hint over the picture, with a button that turns there. It follows the viewer. */
export function turnHint(viewer: Viewer): HTMLElement {
  const text = make('span', { role: 'status' });
  const button = make('button', { type: 'button' }, 'Turn there');
  const hint = make('p', { class: 'turn-hint' }, text, button);
  const follow = () => {
    const next = viewer.onTheWay ? undefined : nextElsewhere(viewer);
    hint.classList.toggle('away', !next);
    button.hidden = !next;
    say(text, next ? `No ring is in view. The next viewpoint is ${next.where}.` : '');
  };
  button.addEventListener('click', () => {
    const next = nextElsewhere(viewer);
    if (!next) return;
    viewer.look(next.look.heading, next.look.elevation);
    viewer.element.querySelector('canvas')?.focus(); // the button is gone
  });
  viewer.onChange(follow);
  follow();
  return hint;
}
