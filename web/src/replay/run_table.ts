/** The table of all runs, with their measures: `/replay`. */
import { addSiteHeader, empty, make, table } from '../elements/page.ts';
import { api } from '../server/api.ts';
import { orderText, parseOrder, type Order, type RunColumn, runColumns, sortHeading, sortRuns } from './columns.ts';
import { address, keyOfRun, type Measures, type Run, runPath } from './runs.ts';

/** Runs whose measures are asked for at once: a server reads all transcripts of a run that it does not know. */
const atOnce = 4;
/** The table waits so long for measures, so that it is mostly drawn once. */
const patienceMs = 700;

const names: readonly RunColumn[] = [
  { name: 'Run', title: 'Run', first: 'ascending', value: ({ run }) => run, text: ({ run }) => run },
  { name: 'Model', title: 'Model', first: 'ascending', value: ({ model }) => model ?? undefined, text: ({ model }) => model ?? 'unknown' },
  { name: 'Prompt', title: 'Prompt', first: 'ascending', value: ({ prompt }) => prompt ?? undefined, text: ({ prompt }) => prompt ?? 'unknown' },
  { name: 'Split', title: 'Split', first: 'ascending', value: keyOfRun, text: (run) => keyOfRun(run) ?? 'unknown' },
];

class RunTable {
  readonly element = make('div');
  private readonly runs: readonly Run[];
  private readonly measures = new Map<string, Measures>();
  private readonly asked = new Set<string>();
  private order: Order | undefined;

  constructor(runs: readonly Run[]) {
    this.runs = runs;
  }

  /** Asks for all measures. The table is drawn when they have come, or after a moment, and again with what comes later. */
  async fill(): Promise<void> {
    const waiting = [...this.runs];
    let drawn = false;
    const ask = async () => {
      for (let one = waiting.shift(); one; one = waiting.shift()) {
        const found = await api.call<Measures>(`${runPath(one.run)}/measures`).catch(() => undefined);
        this.asked.add(one.run);
        if (found) this.measures.set(one.run, found);
        if (drawn) this.draw();
      }
    };
    const all = Promise.all(Array.from({ length: atOnce }, ask));
    await Promise.race([all, new Promise((resolve) => setTimeout(resolve, patienceMs))]);
    this.draw();
    drawn = true;
  }

  private get columns(): readonly RunColumn[] {
    return [...names, ...runColumns(this.runs, [...this.measures.values()])];
  }

  private draw(): void {
    const columns = this.columns;
    this.order ??= parseOrder(new URLSearchParams(location.search).get('sort'), columns);
    const by = columns.find(({ name }) => name === this.order?.by);
    const rows = by ? sortRuns(this.runs, this.measures, by, this.order!.direction) : this.runs;
    const focused = [...this.element.querySelectorAll('th button')].findIndex((one) => one === document.activeElement);
    const heads = columns.map((column) => sortHeading(column, this.order, (order) => {
      this.order = order;
      history.replaceState(null, '', `?${new URLSearchParams({ sort: orderText(order, column.first) })}`);
      this.draw();
    }, !names.includes(column)));
    const cells = rows.map((run) => columns.map((column) => this.cell(run, column)));
    this.element.replaceChildren(table(heads, cells, { kind: 'stack', label: 'Runs' }));
    if (focused >= 0) this.element.querySelectorAll<HTMLElement>('th button')[focused]?.focus();
  }

  private cell(run: Run, column: RunColumn): HTMLElement {
    if (column.name === 'Run') {
      return make('td', { class: 'wide' }, make('a', { href: address({ run: run.run }) }, run.run),
        ...(run.problem ? [make('span', { class: 'method' }, run.problem)] : []));
    }
    const text = column.text(run, this.measures.get(run.run));
    if (names.includes(column)) return make('td', { class: 'half', 'data-label': column.name }, text);
    const label = column.unit ? `${column.name}, ${column.unit}` : column.name;
    return make('td', { class: 'number', 'data-label': label }, column.name === 'Episodes' || this.asked.has(run.run) ? text : '…');
  }
}

/** What stands where there are no runs: how to make one. */
const noRuns = (): HTMLElement => {
  const none = empty('No runs yet',
    'A run is a folder of what a model, an assistant or a program did. This makes one without a model, and shows it:');
  const commands = 'enfilade ask --data DATA --stand-in oracle -o runs/oracle\nenfilade serve DATA --runs runs';
  none.append(make('pre', { class: 'token replay-commands' }, commands),
    make('p', {}, 'With a model: --endpoint URL --model NAME in place of --stand-in oracle.'));
  return none;
};

export async function listRuns(main: HTMLElement): Promise<void> {
  await addSiteHeader();
  const { runs } = await api.call<{ runs: Run[] }>('runs');
  main.append(make('div', { class: 'page-head' }, make('h1', {}, 'Runs'),
    make('p', { class: 'lead' }, 'Language models, assistants and programs on the episodes of a split. A run has its episodes, each step by step. ',
      make('a', { href: '/play' }, 'Play an episode'), ' with the same observations and tools.')));
  if (runs.length === 0) {
    main.append(noRuns());
    return;
  }
  const all = new RunTable(runs);
  main.append(all.element);
  await all.fill();
  const hidden = runs.some(({ outcomes }) => !outcomes);
  main.append(make('p', { class: 'note' }, 'SR, SPL and NE are means of the episodes that a run has.',
    ...(hidden ? [' Where the goals of a split are hidden, nothing is said of success.'] : [])));
}
