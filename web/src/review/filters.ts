/** Which work is shown: by state, worker and path. The page's address has it, so that Back brings it back. */
import { addressOf } from '../collecting/addresses.ts';
import type { WorkSummary } from '../collecting/collections.ts';
import { make } from '../elements/page.ts';
import { api } from '../server/api.ts';
import { duration, states } from './words.ts';

const most = 1000;

/** All of them: the server sends a limited number per request. */
async function summaries(collection: string, by: 'workers' | 'paths'): Promise<WorkSummary[]> {
  const all: WorkSummary[] = [];
  for (let after = -1; ;) {
    const page = (await api.call<Partial<Record<typeof by, WorkSummary[]>>>(
      `${addressOf(collection)}/work/${by}?limit=${most}&after=${after}`))[by] ?? [];
    all.push(...page);
    if (page.length < most) return all;
    after = page.at(-1)![by === 'workers' ? 'worker' : 'path_id']!;
  }
}

function summary(name: string, { submitted, accepted, rejected, flagged, mean_seconds, checks = 0, checks_failed = 0 }: WorkSummary): string {
  const facts = [`${submitted + accepted + rejected} done`, `${duration(mean_seconds)} each`];
  if (rejected > 0) facts.push(`${rejected} rejected`);
  if (flagged > 0) facts.push(`${flagged} with hints`);
  if (checks > 0) facts.push(`${checks_failed} of ${checks} checks failed`);
  return `${name}: ${facts.join(', ')}`;
}

export class Filters {
  private readonly collection: string;
  /** Shown by default. */
  private readonly usual: string;
  private readonly state = make('select', {}, ...states.map(([value, text]) => new Option(text, value)));
  private readonly worker = make('select', {});
  private readonly path = make('select', {});
  readonly element = make('div', { class: 'three' }, make('label', {}, 'Show', this.state), make('label', {}, 'Worker', this.worker),
    make('label', {}, 'Path', this.path));

  /** @param changed is called when another choice is made, also by Back */
  constructor(collection: string, usual: 'submitted' | 'all', changed: () => void) {
    this.collection = collection;
    this.usual = usual;
    for (const [name, select] of this.names()) {
      select.addEventListener('change', () => {
        const query = new URLSearchParams(location.search);
        if (select.value === '' || (name === 'state' && select.value === usual)) query.delete(name);
        else query.set(name, select.value);
        history.pushState(null, '', `?${query}`);
        changed();
      });
    }
    addEventListener('popstate', () => {
      this.followAddress();
      changed();
    });
  }

  /** Fills the lists, and chooses what the page's address names. */
  async open(): Promise<void> {
    const [workers, paths] = await Promise.all([summaries(this.collection, 'workers'), summaries(this.collection, 'paths')]);
    const all = new Option('all', '');
    this.worker.replaceChildren(all, ...workers.map((one) => new Option(summary(`${one.worker}`, one), String(one.worker))));
    this.path.replaceChildren(all.cloneNode(true), ...paths.map((one) => new Option(summary(`${one.path_id}`, one), String(one.path_id))));
    this.followAddress();
  }

  /** For the server. */
  query(): Record<string, string> {
    return { state: this.state.value, ...(this.worker.value && { worker: this.worker.value }), ...(this.path.value && { path_id: this.path.value }) };
  }

  /** Whether all work that waits for review is shown, and no other. */
  get isWholeQueue(): boolean {
    return this.state.value === 'submitted' && !this.worker.value && !this.path.value;
  }

  /** Whether only work that waits is shown. */
  get isQueue(): boolean {
    return this.state.value === 'submitted';
  }

  private names(): [string, HTMLSelectElement][] {
    return [['state', this.state], ['worker', this.worker], ['path', this.path]];
  }

  private followAddress(): void {
    const query = new URLSearchParams(location.search);
    for (const [name, select] of this.names()) select.value = query.get(name) ?? (name === 'state' ? this.usual : '');
  }
}
