/** The instructions of a split, with filters: `/episodes?split=S&q=words&sort=error-down&offset=N`. */
import { jsonFiles, textOf } from '../elements/files.ts';
import { labelled } from '../elements/forms.ts';
import { addSiteHeader, byId, empty, loading, make, problems, run, table, toast } from '../elements/page.ts';
import type { Episode } from '../episodes/episode.ts';
import { type Filters, formatFilters, orders, outcomes, parseFilters } from '../episodes/filters.ts';
import { allEpisodes, errorsOf, successDistance } from '../episodes/navigation_errors.ts';
import { forgetResults, keepResults, keptResults, parseResults, type Results } from '../episodes/results.ts';
import { endCounts, episodesOf, type Split, splitKey, splitTitle } from '../episodes/splits.ts';
import { api } from '../server/api.ts';

interface SplitList {
  readonly splits: readonly Split[];
}
interface EpisodeList {
  readonly matching: number;
  readonly episodes: readonly Episode[];
}
/** A whole split in the browser, with a results file's errors. */
interface Whole {
  readonly split: string;
  readonly results: Results | undefined;
  readonly episodes: readonly Episode[];
  readonly errors: ReadonlyMap<string, number>;
}

const perPage = 50;

/** Episodes without the number to sort by come last. */
function inOrder(episodes: readonly Episode[], { errors }: Whole, order: Filters['order']): Episode[] {
  const list = [...episodes];
  if (order === 'file') return list;
  const value = (episode: Episode) => (order.startsWith('error') ? errors.get(episode.instruction_id) : episode.distance);
  const sign = order === 'error-up' || order === 'shortest' ? 1 : -1;
  return list.sort((a, b) => {
    const [x, y] = [value(a), value(b)];
    if (x === undefined || y === undefined) return Number(x === undefined) - Number(y === undefined);
    return x === y ? 0 : sign * (x - y); // infinite ones too
  });
}

function matches(episode: Episode, { results, errors }: Whole, { scan, words, outcome }: Filters): boolean {
  if (scan && episode.scan !== scan) return false;
  if (!episode.instruction.toLowerCase().includes(words.toLowerCase())) return false;
  const error = errors.get(episode.instruction_id);
  if (outcome === 'failed') return error !== undefined && error >= successDistance;
  if (outcome === 'reached') return error !== undefined && error < successDistance;
  if (outcome === 'missing') return results !== undefined && !results.has(episode.instruction_id);
  return true;
}

class EpisodesPage {
  private readonly splits: readonly string[];
  private readonly list = make('div', { 'aria-live': 'polite' }, loading());
  private readonly fields: { readonly [K in 'split' | 'scan' | 'words' | 'order' | 'outcome']: HTMLInputElement | HTMLSelectElement };
  private readonly boxes: HTMLElement;
  private readonly outcomeBox: HTMLElement;
  private readonly remove = make('button', { type: 'button', class: 'quiet' }, 'Remove');
  private readonly resultsSaid = make('div', { 'aria-live': 'polite' });
  private filters: Filters;
  private whole: Whole | undefined;
  private asked = 0;

  constructor(main: HTMLElement, { splits }: SplitList, scans: readonly string[]) {
    this.splits = splits.map(splitKey);
    this.filters = parseFilters(location.search, this.splits);
    const select = (options: readonly (readonly [string, string])[]) => make('select', {}, ...options.map(([value, text]) => new Option(text, value)));
    const [splitBox, split] = labelled('split', 'Split', select(splits.map((one) => [splitKey(one), splitTitle(one)])));
    const [scanBox, scan] = labelled('scan', 'Building', select([['', 'all'], ...scans.map((name) => [name, name] as const)]));
    const [wordsBox, words] = labelled('words', 'Words in the instruction', make('input', { type: 'search' }));
    const [orderBox, order] = labelled('order', 'Sort by', select(orders));
    const [outcomeBox, outcome] = labelled('outcome', 'Outcome', select(outcomes));
    wordsBox.classList.add('grow');
    this.outcomeBox = outcomeBox;
    this.fields = { split, scan, words, order, outcome };
    this.boxes = make('div', { class: 'toolbar', role: 'search' }, splitBox, scanBox, wordsBox, orderBox, outcomeBox);
    main.append(this.boxes, this.resultsControl(), this.list);
    for (const [name, control] of Object.entries(this.fields)) {
      const typed = name === 'words';
      control.addEventListener(typed ? 'input' : 'change', () => this.change({ [name]: control.value, offset: 0 }, typed));
    }
    addEventListener('popstate', () => {
      this.filters = parseFilters(location.search, this.splits);
      this.refresh();
    });
    this.refresh();
  }

  /** @param typed a key was pressed: the address follows without a step of Back for each */
  private change(some: Partial<Filters>, typed = false): void {
    this.filters = { ...this.filters, ...some };
    if (typed) history.replaceState(null, '', formatFilters(this.filters));
    else history.pushState(null, '', formatFilters(this.filters));
    this.refresh();
  }

  private refresh(): void {
    this.show().catch((error: unknown) => this.list.replaceChildren(problems(error)));
  }

  /** Choosing a results file, whose walks the viewer then shows beside the reference paths. */
  private resultsControl(): HTMLElement {
    const [box, file] = labelled('results', 'Results file of this split', make('input', { type: 'file', accept: jsonFiles }),
      'Shows navigation errors here, and each walk beside its path. The file stays in this browser.');
    const keep = async (): Promise<void> => {
      const text = await textOf(file.files![0]!);
      const { size } = parseResults(text);
      await keepResults(this.filters.split, text);
      this.whole = undefined;
      this.resultsSaid.replaceChildren(make('p', { class: 'done' }, `${size.toLocaleString('en-US')} walks. Open an episode to see one.`));
      this.refresh();
    };
    file.addEventListener('change', () => { keep().catch((error: unknown) => this.resultsSaid.replaceChildren(problems(error))); });
    this.remove.addEventListener('click', () => {
      file.value = '';
      this.resultsSaid.replaceChildren();
      void forgetResults(this.filters.split).then(() => {
        this.whole = undefined;
        toast('The results were removed from this browser.');
        file.focus(); // the button that was pressed is gone
        this.change({ offset: 0, outcome: 'all', ...(this.filters.order.startsWith('error') && { order: 'file' as const }) });
      });
    });
    box.append(' ', this.remove, this.resultsSaid);
    return box;
  }

  /** The page's episodes, and how many match in all. */
  private async find(results: Results | undefined): Promise<EpisodeList> {
    const { split, scan, words, order, outcome, offset } = this.filters;
    if (!results && order === 'file' && outcome === 'all') { // the server does it
      return api.call<EpisodeList>(episodesOf(split, { q: words, scan, offset: String(offset), limit: String(perPage) }));
    }
    const whole = await this.load(split, results);
    const found = inOrder(whole.episodes.filter((one) => matches(one, whole, this.filters)), whole, order);
    return { matching: found.length, episodes: found.slice(offset, offset + perPage) };
  }

  private async load(split: string, results: Results | undefined): Promise<Whole> {
    if (this.whole?.split === split) return this.whole;
    const episodes = await allEpisodes(api, split);
    this.whole = { split, results, episodes, errors: results ? await errorsOf(api, episodes, results) : new Map() };
    return this.whole;
  }

  private async show(): Promise<void> {
    const asked = ++this.asked;
    const results = await keptResults(this.filters.split);
    const found = await this.find(results);
    if (asked !== this.asked) return; // something else was asked for meanwhile
    for (const [name, control] of Object.entries(this.fields)) {
      const value = String(this.filters[name as keyof typeof this.fields]);
      if (control.value !== value) control.value = value;
    }
    this.remove.hidden = this.outcomeBox.hidden = results === undefined;
    if (found.matching === 0) {
      const clear = make('button', { type: 'button' }, 'Clear the filters');
      clear.addEventListener('click', () => this.change({ scan: '', words: '', outcome: 'all', offset: 0 }));
      this.list.replaceChildren(empty('No episode matches', 'Try fewer words, another building or another split.', clear));
      return;
    }
    const { offset } = this.filters;
    const last = Math.min(offset + perPage, found.matching);
    const turn = (text: string, to: number, possible: boolean) => {
      const button = make('button', { type: 'button' }, text);
      button.disabled = !possible;
      button.addEventListener('click', () => { this.change({ offset: Math.max(to, 0) }); this.boxes.scrollIntoView(); });
      return button;
    };
    this.list.replaceChildren(this.table(found.episodes, results),
      make('p', { class: 'pages' }, turn('Previous', offset - perPage, offset > 0), `${offset + 1} to ${last} of ${found.matching.toLocaleString('en-US')}`,
        turn('Next', offset + perPage, last < found.matching)));
  }

  private table(episodes: readonly Episode[], results: Results | undefined): HTMLElement {
    const { split } = this.filters;
    const rows = episodes.map((episode) => {
      const href = `/view?${new URLSearchParams({ split, id: episode.instruction_id })}`;
      return [
        make('td', { class: 'wide' }, make('a', { href }, episode.instruction_id)),
        this.textCell(episode),
        ...(results ? [this.errorCell(episode, results)] : []),
        make('td', { class: 'number', 'data-label': 'Length, m' }, episode.distance?.toFixed(1) ?? (episode.path ? '–' : 'hidden')),
        make('td', { class: 'half', 'data-label': 'Building' }, episode.scan),
      ];
    });
    const length = make('th', { scope: 'col', class: 'number' }, 'Length', make('span', { class: 'unit' }, 'm'));
    const error = make('th', { scope: 'col', class: 'number' }, 'Error', make('span', { class: 'unit' }, 'm'));
    return table(['Id', 'Instruction', ...(results ? [error] : []), length, 'Building'], rows, { kind: 'stack', label: `Episodes of ${split}` });
  }

  private textCell({ instruction, language }: Episode): HTMLElement {
    const cell = make('td', { class: 'wide' }, instruction);
    if (language) {
      cell.lang = language;
      cell.append(' ', make('span', { class: 'badge' }, language));
    }
    return cell;
  }

  private errorCell({ instruction_id }: Episode, results: Results): HTMLElement {
    const error = this.whole?.errors.get(instruction_id);
    const cell = make('td', { class: 'number', 'data-label': 'Error, m' });
    if (error === undefined) cell.append(make('span', { class: 'note' }, results.has(instruction_id) ? 'unknown' : 'no walk'));
    else {
      const good = error < successDistance;
      cell.append(Number.isFinite(error) ? error.toFixed(1) : '∞', ' ');
      if (endCounts(this.filters.split)) cell.append(make('span', { class: good ? 'badge good' : 'badge bad' }, good ? 'success' : 'no success'));
    }
    return cell;
  }
}

run(async () => {
  await addSiteHeader();
  const [splits, { scans }] = await Promise.all([api.call<SplitList>('splits?task=all'), api.call<{ scans: { scan: string }[] }>('scans')]);
  const main = byId('main');
  main.append(make('div', { class: 'page-head' }, make('h1', {}, 'Episodes'),
    make('p', { class: 'lead' }, 'Instructions and the paths that they describe. Open one to see it in its building.')));
  if (splits.splits.length === 0) {
    main.append(empty('No episodes', 'This data set has no annotations.'));
    return;
  }
  new EpisodesPage(main, splits, scans.map(({ scan }) => scan));
});
