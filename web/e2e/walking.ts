/** Walking on the pages of workers, as people do by keys. */
import type { Page } from 'playwright-core';
import type { Viewer } from '../src/viewer/viewer.ts';

declare const window: { walkTask?: { readonly viewer: Viewer } };

/** Runs in the page: turns to a neighbour, and says which of those ahead it is, from 1. */
function face(id: string): number {
  const { viewer } = window.walkTask!;
  const goal = viewer.scan.viewpoints.findIndex((v) => v.id === id);
  const at = (v: number) => viewer.scan.viewpoints[v]!.position;
  const [from, to] = [at(viewer.pose.viewpoint), at(goal)];
  viewer.look(Math.atan2(to[0] - from[0], to[1] - from[1]), 0);
  return viewer.steps().findIndex(({ viewpoint }) => viewpoint === goal) + 1;
}

/** Looks at a neighbour, and goes there by the key of its number in the list. */
export async function stepTo(page: Page, id: string): Promise<void> {
  const number = await page.evaluate(face, id);
  await page.locator('canvas').focus();
  await page.keyboard.press(String(number));
  await page.waitForFunction((to) => {
    const { viewer } = window.walkTask!;
    return viewer.scan.viewpoints[viewer.pose.viewpoint]!.id === to;
  }, id);
}
