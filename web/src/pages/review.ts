/**
 * What workers submitted. `/review?collection=NAME`: one by one, to accept, reject and correct it, with `state`, `worker` and
 * `path` for some of it only; with `view=table` all of it with a search (`q`); with `view=agreement` how far workers agree.
 */
import { addressOf, reviewPage } from '../collecting/addresses.ts';
import type { Collection } from '../collecting/collections.ts';
import { loggedIn, onlyFor, type Who } from '../elements/forms.ts';
import { lacksGraphics } from '../elements/graphics.ts';
import { byId, make, run } from '../elements/page.ts';
import { showQuality } from '../review/quality.ts';
import { showTexts } from '../review/texts.ts';
import { api } from '../server/api.ts';

/** Values of `view`. */
const views = [['', 'One by one'], ['table', 'Table'], ['agreement', 'Agreement and checks']] as const;

async function chooser(who: Who): Promise<void> {
  const { collections } = await api.call<{ collections: Collection[] }>('collections');
  const main = byId('main');
  main.classList.remove('wide');
  main.append(make('h1', {}, 'Review'), loggedIn(who), collections.length === 0 ? make('p', {}, 'There is no collection yet.')
    : make('ul', {}, ...collections.map(({ collection, title, progress }) => make('li', {},
      make('a', { href: reviewPage(collection) }, title), `: ${progress?.submitted ?? 0} to review`))));
}

run(async () => {
  const who = await onlyFor(['organiser', 'reviewer'], 'Review');
  if (!who) return;
  const query = new URLSearchParams(location.search);
  const name = query.get('collection');
  if (!name) return chooser(who);
  const collection = await api.call<Collection>(addressOf(name));
  document.title = `Review ${collection.title} · Enfilade`;
  const view = query.get('view') ?? '';
  const tabs = make('nav', { class: 'tabs', 'aria-label': 'Views' }, ...views.map(([value, text]) => make('a', {
    href: reviewPage(name, value ? { view: value } : {}), ...(value === view && { 'aria-current': 'page' }) }, text)));
  const head = [make('h1', {}, `Review: ${collection.title}`), tabs];
  const main = byId('main');
  if (view === 'table' || view === 'agreement') {
    main.classList.remove('wide');
    main.append(...head);
    return view === 'table' ? showTexts(main, collection) : showQuality(main, collection);
  }
  if (lacksGraphics()) return;
  const { showQueue } = await import('../review/queue.ts'); // it has the viewer, which a table does not need
  await showQueue(main, collection, head);
});
