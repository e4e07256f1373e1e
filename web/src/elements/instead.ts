/** Pages whose address names what is not there. */
import { byId, empty, make } from './page.ts';

const button = (href: string, text: string): HTMLElement => make('a', { href, class: 'button' }, text);

/** Shows this in place of a page, with its name as the heading. */
export function showInstead(page: string, part: HTMLElement): void {
  const main = byId('main');
  main.classList.remove('wide');
  main.replaceChildren(make('h1', {}, page), part);
}

/** @param scan as the address has it; absent: it names none */
export const noBuilding = (scan: string | undefined): HTMLElement => (scan === undefined
  ? empty('No building is named', 'Choose one in the list of buildings.', button('/', 'Buildings'))
  : empty('No such building', `This server has no building "${scan}".`, button('/', 'Buildings')));

/** @param fault "home0001 has no viewpoint x"  @param whole the address of the page for the building as a whole */
export const notInBuilding = (fault: string, scan: string, whole: string): HTMLElement =>
  empty('Not in this building', `${fault}.`, button(whole, `Open ${scan}`), button(`/api/v1/scans/${encodeURIComponent(scan)}/plan.svg`, 'Plan'),
    button('/', 'Buildings'));
