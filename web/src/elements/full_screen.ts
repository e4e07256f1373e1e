/** A view on the whole screen, with its map. */
import { make } from './page.ts';

/**
 * A button that shows the view on the whole screen, and takes the map along: in a corner over the picture.
 * Nothing where the browser has no such thing, as on most phones.
 * @param along stands beside the view otherwise: the map, an episode
 */
export function fullScreenButton(view: HTMLElement, ...along: readonly HTMLElement[]): HTMLButtonElement | undefined {
  if (!document.fullscreenEnabled) return undefined;
  const button = make('button', { type: 'button' }, 'Full screen');
  let leave = () => {};
  button.addEventListener('click', () => void (document.fullscreenElement ? document.exitFullscreen() : view.requestFullscreen()));
  view.addEventListener('fullscreenchange', () => {
    const whole = document.fullscreenElement === view;
    button.textContent = whole ? 'Leave full screen' : 'Full screen';
    if (!whole) return leave();
    const places = along.map((part) => [part, part.parentElement!, part.nextSibling] as const).reverse(); // each is put before the one after it
    leave = () => places.forEach(([part, beside, after]) => beside.insertBefore(part, after));
    view.append(...along);
  });
  return button;
}
