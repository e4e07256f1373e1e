/** Copying links and other texts. */
import { make } from './page.ts';

/** Puts a text on the clipboard; false where the browser lets no page do that. */
async function copied(text: string): Promise<boolean> {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    return false; // no permission, or no https
  }
}

interface LinkCopier {
  readonly button: HTMLButtonElement;
  readonly said: HTMLElement;
}

/**
 * A button that copies a link, and where it is said that it did. Where the browser lets no page copy, a field has the link.
 * @param label of that field  @param done what is said then
 */
export function linkCopier(text: string, label: string, link: () => string, done = 'Link copied'): LinkCopier {
  const said = make('span', { role: 'status', class: 'said' });
  const button = make('button', { type: 'button' }, text);
  let timer = 0;
  button.addEventListener('click', async () => {
    clearTimeout(timer); // of the click before: it would take away what is said now
    said.replaceChildren();
    if (await copied(link())) {
      said.append(done);
      timer = window.setTimeout(() => said.replaceChildren(), 4000);
      return;
    }
    const field = make('input', { type: 'text', readonly: '', 'aria-label': label });
    field.value = link();
    said.append(field);
    field.select();
  });
  return { button, said };
}
