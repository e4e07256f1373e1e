/** Whether this browser can show buildings, checked first, before a worker agrees to a task that can't be done. */
import { make } from '../elements/page.ts';

export function canShowBuildings(): boolean {
  try {
    return document.createElement('canvas').getContext('webgl2') !== null;
  } catch {
    return false;
  }
}

/** Where to go from here, by what the platform put into the page's address. */
function wayBack(query: URLSearchParams): string {
  if (query.has('assignmentId')) return 'If none of this helps, return the HIT. Nothing was recorded, and returning it does you no harm here.';
  if (query.has('PROLIFIC_PID')) return 'If none of this helps, return the submission on Prolific. Nothing was recorded.';
  return 'If none of this helps, use another computer. Nothing was recorded.';
}

export const noGraphics = (query: URLSearchParams): HTMLElement =>
  make('div', { class: 'narrow' },
    make('h1', { tabindex: '-1' }, 'This browser cannot show the buildings'),
    make('p', {}, 'The task is done in three-dimensional pictures. They need WebGL 2, which is off or missing here.'),
    make('h2', {}, 'What you can do'),
    make('ul', {},
      make('li', {}, 'Turn on hardware (or graphics) acceleration in the browser’s settings, restart the browser, and open the link again.'),
      make('li', {}, 'Update the browser, or open the link in another one: Chrome, Edge, Firefox, or Safari 15 and later.'),
      make('li', {}, 'Extensions that protect privacy can switch WebGL off: allow it for this site.')),
    make('p', {}, wayBack(query)));
