/**
 * Runs of the arena, step by step: `/replay` lists them, `/replay?run=NAME` a run's episodes, `/replay?run=NAME&episode=ID#3` shows a
 * step, and `&with=OTHER` another run's walk of the same episode beside it.
 */
import { labelled } from '../elements/forms.ts';
import { linkCopier } from '../elements/link_copier.ts';
import {
  addHeader, addSiteHeader, byId, counted, crumbs, empty, type Link, make, problems, run, type Served, table,
} from '../elements/page.ts';
import { splitKey } from '../episodes/splits.ts';
import { RunPanel } from '../replay/run_panel.ts';
import { endText, type ListedEpisode, parseStep, type Replay, type Run } from '../replay/runs.ts';
import { api } from '../server/api.ts';
import type { Viewer } from '../viewer/enfilade-viewer.ts';
import './replay.css';

declare global {
  interface Window {
    /** For tests, and for the curious at the console. */
    replay?: { readonly step: number; readonly viewers: readonly (Viewer | undefined)[] };
  }
}

const perPage = 500;
const runsPage: Link = ['/replay', 'Runs'];

const splitOf = ({ task, split }: Pick<Run, 'task' | 'split'>): string => (task && split ? splitKey({ task, split }) : 'unknown');
const address = (parts: Readonly<Record<string, string>>, hash = ''): string => `/replay?${new URLSearchParams(parts)}${hash}`;
const runPath = (name: string): string => `runs/${encodeURIComponent(name)}`;

async function listRuns(main: HTMLElement): Promise<void> {
  await addSiteHeader();
  const { runs } = await api.call<{ runs: Run[] }>('runs');
  main.append(make('div', { class: 'page-head' }, make('h1', {}, 'Runs'),
    make('p', { class: 'lead' }, 'Walks of language models, assistants and programs. Open one to see what it thought and did, step by step. ',
    make('a', { href: '/play' }, 'Walk as they do'), ', by the same words and tools.')));
  if (runs.length === 0) {
    main.append(empty('No runs', 'A server shows the runs that it is started with: enfilade serve DATA --runs DIR.'));
    return;
  }
  main.append(table(['Run', 'Split', 'Model', 'Prompt', make('th', { scope: 'col', class: 'number' }, 'Episodes')], runs.map((one) => [
    make('td', { class: 'wide' }, make('a', { href: address({ run: one.run }) }, one.run), ...(one.problem ? [make('span', { class: 'method' }, one.problem)] : [])),
    make('td', { class: 'half', 'data-label': 'Split' }, splitOf(one)),
    make('td', { class: 'half', 'data-label': 'Model' }, one.model ?? 'unknown'),
    make('td', { class: 'half', 'data-label': 'Prompt' }, one.prompt ?? 'unknown'),
    make('td', { class: 'number', 'data-label': 'Episodes' }, one.episodes.toLocaleString('en-US'))]), { kind: 'stack', label: 'Runs' }));
}

async function listEpisodes(main: HTMLElement, name: string): Promise<void> {
  await addSiteHeader();
  const offset = Math.max(0, Math.trunc(Number(new URLSearchParams(location.search).get('offset'))) || 0);
  const found = await api.call<Run & { list: ListedEpisode[] }>(`${runPath(name)}?offset=${offset}&limit=${perPage}`);
  document.title = `${found.run} · Enfilade`;
  const facts = [`split ${splitOf(found)}`, ...(found.model ? [`model ${found.model}`] : []), ...(found.prompt ? [`prompt ${found.prompt}`] : []),
    `${counted(found.episodes, 'episode')} done`];
  main.append(crumbs([runsPage], found.run), make('div', { class: 'page-head' }, make('h1', {}, found.run), make('p', { class: 'lead' }, facts.join(', '))));
  if (found.problem) main.append(make('p', { class: 'notice' }, found.problem));
  const rows = found.list.map((one) => [
    make('td', { class: 'wide' }, make('a', { href: address({ run: found.run, episode: one.episode }) }, one.episode)),
    'problem' in one ? make('td', { class: 'wide problem' }, one.problem) : make('td', { class: 'wide' }, endText(one))]);
  main.append(rows.length > 0 ? table(['Episode', 'How it ended'], rows, { kind: 'stack', label: `Episodes of ${found.run}` })
    : empty('No episodes', 'This run has no finished episode.'));
  const turn = (text: string, to: number) => make('a', { class: 'button', href: address({ run: found.run, offset: String(to) }) }, text);
  if (found.episodes > perPage) {
    main.append(make('p', { class: 'pages' }, ...(offset > 0 ? [turn('Previous', Math.max(0, offset - perPage))] : []),
      `${offset + 1} to ${offset + found.list.length} of ${found.episodes.toLocaleString('en-US')}`,
      ...(offset + perPage < found.episodes ? [turn('Next', offset + perPage)] : [])));
  }
}

class EpisodePage {
  private readonly panels: readonly RunPanel[];
  private readonly slider = make('input', { type: 'range', min: '1', 'aria-label': 'Step' });
  private readonly place = make('p', { role: 'status', class: 'replay-place' });
  private readonly back = make('button', { type: 'button' }, 'Previous');
  private readonly on = make('button', { type: 'button' }, 'Next');
  private readonly steps = make('ol', { class: 'replay-steps' });
  private readonly length: number;
  private at = 0;
  /** Steps that were asked for while one was being shown wait; of several the last counts. */
  private showing: Promise<void> = Promise.resolve();

  constructor(panels: readonly RunPanel[]) {
    this.panels = panels;
    this.length = Math.max(...panels.map(({ length }) => length));
    this.slider.max = String(this.length);
    this.back.addEventListener('click', () => this.go(this.at - 1));
    this.on.addEventListener('click', () => this.go(this.at + 1));
    this.slider.addEventListener('input', () => this.go(Number(this.slider.value)));
    addEventListener('hashchange', () => this.go(parseStep(location.hash, this.length)));
    addEventListener('keydown', (event) => this.key(event));
    this.steps.append(...Array.from({ length: this.length }, (_, k) => {
      const button = make('button', { type: 'button', class: 'quiet' }, panels.map((panel) => panel.title(Math.min(k + 1, panel.length))).join(' | '));
      button.addEventListener('click', () => this.go(k + 1));
      return make('li', {}, button);
    }));
  }

  /** Which step is shown, and those who choose one. */
  controls(...more: readonly HTMLElement[]): HTMLElement {
    const { button, said } = linkCopier('Copy link', 'Link to this step', () => location.href);
    return make('div', { class: 'replay-controls' }, make('div', { class: 'replay-player' }, this.back, this.slider, this.on, this.place),
      make('div', { class: 'buttons' }, button, said, ...more),
      make('details', {}, make('summary', {}, 'All steps'), this.steps));
  }

  get step(): number {
    return this.at;
  }

  async open(): Promise<void> {
    await Promise.all(this.panels.map((panel) => panel.open()));
    this.go(parseStep(location.hash, this.length));
    await this.showing;
  }

  private go(number: number): void {
    const to = Math.min(Math.max(number, 1), this.length);
    if (to === this.at) return;
    this.at = to;
    history.replaceState(null, '', `#${to}`);
    this.slider.value = String(to);
    const text = to === this.length ? 'The end' : `Step ${to} of ${this.length - 1}`;
    this.slider.setAttribute('aria-valuetext', text);
    this.place.textContent = text;
    // Not disabled, as that would take the focus from who presses it.
    this.back.ariaDisabled = to === 1 ? 'true' : null;
    this.on.ariaDisabled = to === this.length ? 'true' : null;
    [...this.steps.querySelectorAll('button')].forEach((button, k) => {
      if (k + 1 === to) button.setAttribute('aria-current', 'step');
      else button.removeAttribute('aria-current');
    });
    this.showing = this.showing.then(async () => {
      if (to === this.at) await Promise.all(this.panels.map((panel) => panel.show(to)));
    }).catch((error: unknown) => { byId('main').append(problems(error)); });
  }

  /** Arrow keys go on and back, where they have no other use. */
  private key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey || event.shiftKey) return;
    if ((event.target as HTMLElement).closest('input, select, textarea, canvas, [tabindex="0"]')) return;
    if (event.key !== 'ArrowLeft' && event.key !== 'ArrowRight') return;
    event.preventDefault();
    this.go(this.at + (event.key === 'ArrowRight' ? 1 : -1));
  }
}

/** Chooses the run beside; changing it keeps the step. */
async function besideControl(shown: Replay, other: string): Promise<HTMLElement | undefined> {
  const { runs } = await api.call<{ runs: Run[] }>(`runs?${new URLSearchParams({ episode: shown.episode })}`);
  const same = runs.filter(({ run: name, task, split }) => name !== shown.run && task === shown.task && split === shown.split);
  if (same.length === 0) return undefined;
  const [box, select] = labelled('with', 'Beside', make('select', {}, new Option('no other run', ''), ...same.map(({ run: name }) => new Option(name, name))));
  select.value = other;
  box.classList.add('replay-beside');
  select.addEventListener('change', () => {
    location.assign(address({ run: shown.run, episode: shown.episode, ...(select.value && { with: select.value }) }, location.hash));
  });
  return box;
}

async function showEpisode(main: HTMLElement, name: string, episode: string): Promise<void> {
  const other = new URLSearchParams(location.search).get('with') ?? '';
  const ask = (from: string) => api.call<Replay>(`${runPath(from)}/episodes/${encodeURIComponent(episode)}`);
  addHeader(await api.call<Served>('scans'));
  main.append(crumbs([runsPage, [address({ run: name }), name]], episode)); // also where the transcript cannot be read
  const [shown, beside] = await Promise.all([ask(name), other ? ask(other) : undefined]);
  if (beside && (beside.task !== shown.task || beside.split !== shown.split)) {
    throw new Error(`${beside.run} is a run of split ${splitOf(beside)}, and ${shown.run} of ${splitOf(shown)}.`);
  }
  document.title = `${episode} of ${shown.run} · Enfilade`;
  main.classList.add('wide', 'replay');
  const panels = [shown, ...(beside ? [beside] : [])].map((one) => new RunPanel(one));
  const page = new EpisodePage(panels);
  const links: HTMLElement[] = shown.task && shown.split && shown.steps[0]?.at
    ? [make('a', { class: 'button', href: `/play?${new URLSearchParams({ task: shown.task, split: shown.split, episode })}` }, 'Walk it yourself')] : [];
  const picker = await besideControl(shown, other);
  main.replaceChildren(
    make('div', { class: 'replay-head' }, crumbs([runsPage, [address({ run: shown.run }), shown.run]], episode),
      make('h1', {}, `Episode ${episode}`), make('p', { class: 'instruction' }, shown.instruction),
      page.controls(...links, ...(picker ? [picker] : []))),
    make('div', { class: panels.length > 1 ? 'replay-runs two' : 'replay-runs' }, ...panels.map(({ element }) => element)));
  await page.open();
  window.replay = { get step() { return page.step; }, get viewers() { return panels.map(({ viewer }) => viewer); } };
}

run(async () => {
  const main = byId('main');
  const query = new URLSearchParams(location.search);
  const [name, episode] = [query.get('run'), query.get('episode')];
  if (name && episode) await showEpisode(main, name, episode);
  else if (name) await listEpisodes(main, name);
  else await listRuns(main);
}, 'This run cannot be shown');
