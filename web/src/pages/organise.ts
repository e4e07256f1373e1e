/** Collections: making them, how far they are, their links and files. */
import { cardOf, type CardHost } from '../collecting/card.ts';
import type { Collection } from '../collecting/collections.ts';
import { newCollection, type Preview } from '../collecting/new_collection.ts';
import type { SplitList } from '../collecting/source_fields.ts';
import { loggedIn, onlyFor } from '../elements/forms.ts';
import { byId, make, run } from '../elements/page.ts';
import { teamsBox } from '../evaluation/teams.ts';
import { api } from '../server/api.ts';

/** A task as workers see it. */
async function look({ collection, example }: Preview): Promise<void> {
  const { showPreview } = await import('../work/preview.ts'); // it has the viewer, which nothing else here needs
  await showPreview(collection, example);
}

run(async () => {
  const who = await onlyFor(['organiser', 'reviewer'], 'Collections');
  if (!who) return;
  const organiser = who.role === 'organiser';
  const list = make('ul', { class: 'collections', 'aria-label': 'Collections' });
  const main = byId('main');
  const search = make('input', { type: 'search', 'aria-label': 'Search collections', placeholder: 'Search' });
  const archived = make('input', { type: 'checkbox' });
  const filters = make('div', { class: 'filters' }, search, make('label', { class: 'row' }, archived, 'Show archived'));
  const none = make('p');
  const host: CardHost = { organiser, changed: () => refresh(), preview: look };
  const refresh = async (): Promise<void> => {
    const query = new URLSearchParams({ q: search.value, ...(archived.checked && { state: 'archived' }) });
    const { collections } = await api.call<{ collections: Collection[] }>(`collections?${query}`);
    none.textContent = search.value || archived.checked ? 'No collection matches.' : organiser ? 'No collections yet.' : 'No collections yet; organisers create them.';
    list.replaceChildren(...collections.reverse().map((one) => cardOf(one, host))); // the newest first
    list.hidden = collections.length === 0;
    none.hidden = collections.length > 0;
  };
  const box = make('details', { class: 'new' }, make('summary', {}, make('h2', {}, 'New collection')));
  main.append(make('h1', {}, 'Collections'), loggedIn(who), ...(organiser ? [box] : []), filters, none, list);
  await refresh();
  for (const control of [search, archived]) control.addEventListener('input', () => void refresh());
  setInterval(() => {
    // Not while the organiser uses it, nor over a form that is filled in.
    const used = list.contains(document.activeElement) || list.querySelector('details[open], .card-panel:not(:empty)') !== null;
    if (!document.hidden && !used) refresh().catch(() => {});
  }, 15_000);
  if (!organiser) return;
  const splits = await api.call<SplitList>('splits');
  // Anew after each collection: nothing of one study may get into the next.
  const fill = (): void => {
    box.querySelector('form')?.remove();
    box.append(newCollection(splits, made, look));
  };
  const made = async ({ collection }: Collection): Promise<void> => {
    fill();
    box.open = false;
    search.value = '';
    archived.checked = false;
    await refresh();
    const card = list.querySelector<HTMLElement>(`[data-collection='${collection}']`)!; // a-z, 0-9, - and _
    card.classList.add('made');
    card.querySelector('h2')!.after(make('p', { class: 'done', role: 'status' }, 'The collection is open. Send its link to workers.'));
    card.scrollIntoView({ block: 'center' });
    card.querySelector('h2')!.focus({ preventScroll: true });
  };
  fill();
  box.open = !none.hidden;
  main.append(await teamsBox());
});
