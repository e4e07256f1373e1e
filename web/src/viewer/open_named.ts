/** Opening a viewer where an address says, on a page that tells what is not there. */
import { noBuilding, notInBuilding, showInstead } from '../elements/instead.ts';
import { ServerError } from '../server/api.ts';
import { NotInScan } from './arrival.ts';
import { formatLink } from './deep_link.ts';
import type { ViewerOptions } from './options.ts';
import { Viewer } from './viewer.ts';

/**
 * Nothing if the building or the viewpoint is not there: the page says so then. Throws as Viewer.open().
 * @param page its name, and its address: "/view"
 */
export async function openNamed(
  element: HTMLElement, options: ViewerOptions, page: { readonly name: string; readonly path: string },
): Promise<Viewer | undefined> {
  try {
    return await Viewer.open(element, options);
  } catch (error) {
    if (error instanceof NotInScan) {
      showInstead(page.name, notInBuilding(error.message, options.scan, `${page.path}${formatLink({ scan: options.scan })}`));
    } else if (error instanceof ServerError && error.status === 404) showInstead(page.name, noBuilding(options.scan));
    else throw error;
    return undefined;
  }
}
