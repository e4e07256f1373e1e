/** The instructions of a split, with filters: `/episodes?split=S&q=words&sort=error-down&offset=N`. */
import { jsonFiles, textOf } from '../elements/files.ts';
import { labelled } from '../elements/forms.ts';
import { addSiteHeader, byId, counted, empty, loading, make, problems, run, table, toast } from '../elements/page.ts';
import { type Episode, shownText } from '../episodes/episode.ts';
import { type Filters, formatFilters, narrowing, orders, outcomes, parseFilters, perPage } from '../episodes/filters.ts';
import { Listing } from '../episodes/listing.ts';
import { successDistance } from '../episodes/navigation_errors.ts';
import { forgetResults, keepResults, keptResults, parseResults, type Results } from '../episodes/results.ts';
import { SplitChoice } from '../episodes/split_choice.ts';
import { endCounts, episodePage, isOnFloor, type Offered, offeredBenchmarks, parseKey, type SplitList } from '../episodes/splits.ts';
import { api, reachability } from '../server/api.ts';

class EpisodesPage {
  private readonly splits: readonly string[];
  private readonly listing = new Listing(api);
  private readonly list = make('div', { 'aria-live': 'polite' }, loading());
  private readonly choice: SplitChoice;
  private readonly fields: { readonly [K in 'scan' | 'words' | 'order' | 'outcome']: HTMLInputElement | HTMLSelectElement };
  private readonly boxes: HTMLElement;
  private readonly outcomeBox: HTMLElement;
  private readonly resultsBox: HTMLElement;
  private readonly remove = make('button', { type: 'button', class: 'quiet' }, 'Remove');
  private readonly resultsSaid = make('div', { 'aria-live': 'polite' });
  private filters: Filters;
  private asked = 0;

  constructor(main: HTMLElement, offered: readonly Offered[], scans: readonly string[]) {
    this.splits = offered.flatMap(({ splits }) => splits.map(({ key }) => key));
    this.filters = parseFilters(location.search, this.splits);
    const unknown = this.unknownSplit();
    this.choice = new SplitChoice(offered, (split) => {
      unknown?.remove(); // another one is shown now
      this.change({ split, offset: 0 });
    });
    const select = (options: readonly (readonly [string, string])[]) =>
      make('select', {}, ...options.map(([value, text]) => new Option(text, value)));
    const [scanBox, scan] = labelled('scan', 'Building', select([['', 'all'], ...scans.map((name) => [name, name] as const)]));
    const [wordsBox, words] = labelled('words', 'Words in the instruction', make('input', { type: 'search' }));
    const [orderBox, order] = labelled('order', 'Sort by', select(orders));
    const [outcomeBox, outcome] = labelled('outcome', 'Outcome', select(outcomes));
    wordsBox.classList.add('grow');
    this.outcomeBox = outcomeBox;
    this.fields = { scan, words, order, outcome };
    this.boxes = make('div', { class: 'toolbar', role: 'search' }, ...this.choice.boxes, scanBox, wordsBox, orderBox, outcomeBox);
    this.resultsBox = this.resultsControl();
    main.append(...(unknown ? [unknown] : []), this.boxes, this.resultsBox, this.list);
    for (const [name, control] of Object.entries(this.fields)) {
      const typed = name === 'words';
      control.addEventListener(typed ? 'input' : 'change', () => this.change({ [name]: control.value, offset: 0 }, typed));
    }
    addEventListener('popstate', () => {
      this.filters = parseFilters(location.search, this.splits);
      this.refresh();
    });
    reachability.addEventListener('back', () => this.refresh()); // what was asked for meanwhile
    this.refresh();
  }

  /** What the address names, and no list has. */
  private unknownSplit(): HTMLElement | undefined {
    const wanted = new URLSearchParams(location.search).get('split');
    if (!wanted || this.splits.includes(wanted)) return undefined;
    return make('p', { class: 'notice' }, `This data set has no split "${wanted}" with episodes. Shown is ${this.filters.split}.`);
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
      'Shows navigation errors here, and each trajectory beside its path. The file stays in this browser.');
    const keep = async (): Promise<void> => {
      const text = await textOf(file.files![0]!);
      const { size } = parseResults(text);
      await keepResults(this.filters.split, text);
      this.listing.forget();
      this.resultsSaid.replaceChildren(make('p', { class: 'done' }, `${counted(size, 'walk')}. Open an episode to see one.`));
      this.refresh();
    };
    file.addEventListener('change', () => { keep().catch((error: unknown) => this.resultsSaid.replaceChildren(problems(error))); });
    this.remove.addEventListener('click', () => {
      file.value = '';
      this.resultsSaid.replaceChildren();
      void forgetResults(this.filters.split).then(() => {
        this.listing.forget();
        toast('The results were removed from this browser.');
        file.focus(); // the button that was pressed is gone
        this.change({ offset: 0, outcome: 'all', ...(this.filters.order.startsWith('error') && { order: 'file' as const }) });
      });
    });
    box.append(' ', this.remove, this.resultsSaid);
    return box;
  }

  private async show(): Promise<void> {
    const asked = ++this.asked;
    const { filters } = this;
    const onFloor = isOnFloor(filters.split); // its walks are no viewpoints
    const results = onFloor ? undefined : await keptResults(filters.split);
    const found = await this.listing.find(filters, results);
    if (asked !== this.asked) return; // something else was asked for meanwhile
    this.choice.value = filters.split;
    for (const [name, control] of Object.entries(this.fields)) {
      const value = String(filters[name as keyof typeof this.fields]);
      if (control.value !== value) control.value = value;
    }
    this.resultsBox.hidden = onFloor;
    this.remove.hidden = this.outcomeBox.hidden = results === undefined;
    if (found.matching === 0) {
      const clear = make('button', { type: 'button' }, 'Clear the filters');
      clear.addEventListener('click', () => this.change({ scan: '', words: '', outcome: 'all', offset: 0 }));
      this.list.replaceChildren(empty('No episode matches', 'Try fewer words, another building or another split.', clear));
      return;
    }
    const { offset } = filters;
    const last = Math.min(offset + perPage, found.matching);
    const turn = (text: string, to: number, possible: boolean) => {
      const button = make('button', { type: 'button' }, text);
      button.disabled = !possible;
      button.addEventListener('click', () => { this.change({ offset: Math.max(to, 0) }); this.boxes.scrollIntoView(); });
      return button;
    };
    const shown = `${offset + 1} to ${last} of ${found.matching.toLocaleString('en-US')}`;
    this.list.replaceChildren(this.table(found.episodes, results), make('p', { class: 'pages' },
      turn('Previous', offset - perPage, offset > 0), shown, turn('Next', offset + perPage, last < found.matching)));
  }

  private table(episodes: readonly Episode[], results: Results | undefined): HTMLElement {
    const { split } = this.filters;
    const length = isOnFloor(split) ? 'Distance' : 'Length'; // to the goal by the floor; of the path
    const list = narrowing(this.filters);
    const link = ({ instruction_id: id }: Episode) => make('a', { href: episodePage(split, id, list) }, id);
    const rows = episodes.map((episode) => [
      make('td', { class: 'wide' }, link(episode)),
      this.textCell(episode),
      ...(results ? [this.errorCell(episode, results)] : []),
      make('td', { class: 'number', 'data-label': `${length}, m` }, episode.distance?.toFixed(1) ?? (episode.path ? '–' : 'hidden')),
      make('td', { class: 'half', 'data-label': 'Building' }, episode.scan),
    ]);
    const column = (name: string) => make('th', { scope: 'col', class: 'number' }, name, make('span', { class: 'unit' }, 'm'));
    const head = ['Id', 'Instruction', ...(results ? [column('Error')] : []), column(length), 'Building'];
    return table(head, rows, { kind: 'stack', label: `Episodes of ${split}` });
  }

  private textCell({ instruction, language }: Episode): HTMLElement {
    const cell = make('td', { class: 'wide shown' }, shownText(instruction, parseKey(this.filters.split).task));
    if (language) {
      cell.lang = language;
      cell.append(' ', make('span', { class: 'badge' }, language));
    }
    return cell;
  }

  private errorCell({ instruction_id }: Episode, results: Results): HTMLElement {
    const error = this.listing.error(instruction_id);
    const cell = make('td', { class: 'number', 'data-label': 'Error, m' });
    if (error === undefined) cell.append(make('span', { class: 'note' }, results.has(instruction_id) ? 'unknown' : 'no trajectory'));
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
  const offered = offeredBenchmarks(splits);
  if (offered.length === 0) {
    main.append(empty('No episodes', 'This data set has no annotations.'));
    return;
  }
  new EpisodesPage(main, offered, scans.map(({ scan }) => scan));
});
