/** A button that opens a list of what else can be done. */
import { make } from './page.ts';

/**
 * By keys: Tab and Enter, and Escape closes it. It closes by itself once something in it was chosen, or the focus has left it.
 * @param label what screen readers say of it
 */
export function menu(text: string, label: string, entries: readonly HTMLElement[]): HTMLDetailsElement {
  const summary = make('summary', { 'aria-label': label }, text);
  const box = make('details', { class: 'menu' }, summary, make('ul', {}, ...entries.map((entry) => make('li', {}, entry))));
  const close = (): void => {
    if (box.contains(document.activeElement)) summary.focus();
    box.open = false;
  };
  box.addEventListener('keydown', (event) => { if (event.key === 'Escape') close(); });
  box.addEventListener('focusout', ({ relatedTarget }) => {
    if (relatedTarget instanceof Node && !box.contains(relatedTarget)) box.open = false;
  });
  for (const entry of entries) entry.addEventListener('click', close);
  return box;
}
