/** Whether this browser can show buildings. Pages ask it first: before a worker agrees to a task, and before anything is fetched. */
import { byId, make } from './page.ts';

export function canShowBuildings(): boolean {
  try {
    return document.createElement('canvas').getContext('webgl2') !== null;
  } catch {
    return false;
  }
}

/** For a line where the pictures would be. */
export const noGraphicsText = 'This browser cannot show the buildings: WebGL 2 is off or missing.';

/** Where a worker can go from here, by what the platform put into the page's address. */
export function workersWayBack(query: URLSearchParams): string {
  if (query.has('assignmentId')) return 'If none of this helps, return the HIT. Nothing was recorded, and returning it does you no harm here.';
  if (query.has('PROLIFIC_PID')) return 'If none of this helps, return the submission on Prolific. Nothing was recorded.';
  return 'If none of this helps, use another computer. Nothing was recorded.';
}

/** @param wayBack the last paragraph */
export const noGraphics = (...wayBack: readonly (Node | string)[]): HTMLElement =>
  make('div', { class: 'narrow' },
    make('h1', { tabindex: '-1' }, 'This browser cannot show the buildings'),
    make('p', {}, 'Buildings are shown in three-dimensional pictures. They need WebGL 2, which is off or missing here.'),
    make('h2', {}, 'What you can do'),
    make('ul', {},
      make('li', {}, 'Turn on hardware (or graphics) acceleration in the browser’s settings, restart the browser, and open the link again.'),
      make('li', {}, 'Update the browser, or open the link in another one: Chrome, Edge, Firefox, or Safari 15 and later.'),
      make('li', {}, 'Extensions that protect privacy can switch WebGL off: allow it for this site.')),
    make('p', {}, ...wayBack));

/** On visitors' pages: shows this in place of the page where the browser cannot show buildings. Returns whether it did. */
export function lacksGraphics(): boolean {
  if (canShowBuildings()) return false;
  const main = byId('main');
  const link = (href: string, text: string) => make('a', { href }, text);
  main.classList.remove('wide');
  main.replaceChildren(noGraphics('Without it you can read ', link('/', 'the buildings’ plans'), ', ', link('/episodes', 'the episodes'), ' and ',
    link('/leaderboard', 'the leaderboard'), '.'));
  return true;
}
