/** An episode of a run, or of two runs side by side, step by step: `/replay?run=R&episode=E#3`. */
import { action, labelled } from '../elements/forms.ts';
import { linkCopier } from '../elements/link_copier.ts';
import { addSiteHeader, byId, crumbs, make, problems } from '../elements/page.ts';
import { episodePage, isOnFloor } from '../episodes/splits.ts';
import { api } from '../server/api.ts';
import type { Viewer } from '../viewer/enfilade-viewer.ts';
import { runsPage } from './episode_table.ts';
import { RunPanel } from './run_panel.ts';
import { address, episodePath, keyOfRun, parseStep, type Replay, type Run } from './runs.ts';

declare global {
  interface Window {
    /** For tests, and for the curious at the console. */
    replay?: { readonly step: number; readonly viewers: readonly (Viewer | undefined)[] };
  }
}

/** Between two steps that are played. */
const playMs = 1500;

class EpisodePage {
  private readonly panels: readonly RunPanel[];
  private readonly slider = make('input', { type: 'range', min: '1', 'aria-label': 'Step' });
  private readonly place = make('p', { role: 'status', class: 'replay-place' });
  private readonly back = make('button', { type: 'button' }, 'Previous');
  private readonly on = make('button', { type: 'button' }, 'Next');
  private readonly playing = make('button', { type: 'button', class: 'main' }, 'Play');
  private readonly steps = make('ol', { class: 'replay-steps' });
  private readonly length: number;
  private at = 0;
  private timer = 0;
  /** Steps that were asked for while one was being shown wait; of several the last counts. */
  private showing: Promise<void> = Promise.resolve();

  constructor(panels: readonly RunPanel[]) {
    this.panels = panels;
    this.length = Math.max(...panels.map(({ length }) => length));
    this.slider.max = String(this.length);
    const choose = (number: () => number) => () => {
      this.pause();
      this.go(number());
    };
    this.back.addEventListener('click', choose(() => this.at - 1));
    this.on.addEventListener('click', choose(() => this.at + 1));
    this.slider.addEventListener('input', choose(() => Number(this.slider.value)));
    this.playing.addEventListener('click', () => this.togglePlay());
    addEventListener('hashchange', choose(() => parseStep(location.hash, this.length)));
    addEventListener('keydown', (event) => this.key(event));
    this.steps.append(...Array.from({ length: this.length }, (_, k) => {
      const title = panels.map((panel) => panel.title(Math.min(k + 1, panel.length))).join(' | ');
      const button = make('button', { type: 'button', class: 'quiet' }, title);
      button.addEventListener('click', choose(() => k + 1));
      return make('li', {}, button);
    }));
  }

  /** Which step is shown, and those who choose one. @param more of the second row, where it is open */
  controls(...more: readonly HTMLElement[]): HTMLElement[] {
    const { button, said } = linkCopier('Copy link', 'Link to this step', () => location.href);
    return [make('div', { class: 'replay-player' }, this.back, this.playing, this.on, this.slider, this.place), button, said,
      make('details', { class: 'replay-more' }, make('summary', {}, 'More'), make('div', { class: 'buttons' }, ...more),
        make('h2', {}, 'All steps'), this.steps)];
  }

  get step(): number {
    return this.at;
  }

  async open(): Promise<void> {
    const first = parseStep(location.hash, this.length);
    await Promise.all(this.panels.map((panel) => panel.open(first)));
    this.go(first);
    await this.showing;
  }

  private pause(): void {
    clearTimeout(this.timer);
    this.timer = 0;
    this.playing.textContent = 'Play';
  }

  /** From here on, or from the beginning where it is the end. */
  private togglePlay(): void {
    if (this.timer) return this.pause();
    if (this.at === this.length) this.go(1);
    this.playing.textContent = 'Pause';
    const wait = () => {
      const own = this.timer = window.setTimeout(() => void this.showing.then(() => {
        if (this.timer !== own) return; // paused meanwhile, and perhaps begun again
        this.go(this.at + 1);
        if (this.at === this.length) this.pause();
        else wait();
      }), playMs);
    };
    wait();
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
    this.show(to);
  }

  /** Shows a step after what is being shown, if it is the last one that was asked for. */
  private show(to: number): void {
    this.showing = this.showing.then(async () => {
      if (to === this.at) await Promise.all(this.panels.map((panel) => panel.show(to)));
    }).catch((error: unknown) => { byId('main').append(problems(error)); });
  }

  /** Saves the steps of the first run as a film. */
  filmControl(): HTMLElement[] {
    const panel = this.panels[0]!;
    const said = make('span', { role: 'status', class: 'said' });
    const button = action('Save as GIF', said, async () => {
      this.pause();
      const { canBeFilmed, filmOf } = await import('./film.ts'); // few ask for it
      if (!canBeFilmed(panel)) throw new Error('There are no pictures of this run here');
      const making = this.showing.then(() => filmOf(panel, (step, all) => { said.textContent = `Step ${step} of ${all}`; }));
      this.showing = making.then(() => {}, () => {}); // steps that are asked for meanwhile wait
      this.show(this.at); // after it, the view that was there before
      const film = await making;
      const name = `${panel.replay.run}_${panel.replay.episode}.gif`.replace(/[^\w.-]/g, '_');
      const link = make('a', { href: URL.createObjectURL(film), download: name });
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
      said.textContent = `Saved: ${(film.size / 1e6).toFixed(1)} MB`;
    });
    return [button, said];
  }

  /** Arrow keys go on and back, and the space bar plays, where they have no other use. */
  private key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey || event.shiftKey) return;
    const target = event.target as HTMLElement;
    if (target.closest('input, select, textarea, canvas, [tabindex="0"]')) return;
    const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (by !== undefined) {
      event.preventDefault();
      this.pause();
      this.go(this.at + by);
    } else if (event.key === ' ' && !target.closest('button, a, summary')) {
      event.preventDefault();
      this.togglePlay();
    }
  }
}

/** Chooses the other run; changing it keeps the step. */
async function compareControl(shown: Replay, other: string): Promise<HTMLElement | undefined> {
  const { runs } = await api.call<{ runs: Run[] }>(`runs?${new URLSearchParams({ episode: shown.episode })}`);
  const same = runs.filter(({ run: name, task, split }) => name !== shown.run && task === shown.task && split === shown.split);
  if (same.length === 0) return undefined;
  const options = [new Option('no run', ''), ...same.map(({ run: name }) => new Option(name, name))];
  const [box, select] = labelled('with', 'Compare with', make('select', {}, ...options));
  select.value = other;
  box.classList.add('replay-with');
  select.addEventListener('change', () => {
    location.assign(address({ run: shown.run, episode: shown.episode, ...(select.value && { with: select.value }) }, location.hash));
  });
  return box;
}

/** Other pages of the episode. */
function linksOf(shown: Replay, other: string): HTMLElement[] {
  const { task, split, episode } = shown;
  const key = keyOfRun(shown);
  const link = (href: string, text: string) => make('a', { class: 'button', href }, text);
  if (!task || !split || !key) return [];
  return [
    ...(shown.scan || isOnFloor(key) ? [link(episodePage(key, episode), 'Episode')] : []),
    ...(shown.steps[0]?.at ? [link(`/play?${new URLSearchParams({ task, split, episode })}`, 'Play it yourself')] : []),
    ...(other ? [link(address({ run: shown.run, with: other }), 'Both runs')] : [])];
}

export async function showEpisode(main: HTMLElement, name: string, episode: string): Promise<void> {
  const other = new URLSearchParams(location.search).get('with') ?? '';
  const ask = (from: string) => api.call<Replay>(episodePath(from, episode));
  void addSiteHeader();
  const above = crumbs([runsPage, [address({ run: name }), name]], episode);
  const read = async (): Promise<[Replay, Replay | undefined]> => {
    const [shown, beside] = await Promise.all([ask(name), other ? ask(other) : undefined]);
    if (beside && (beside.task !== shown.task || beside.split !== shown.split)) {
      throw new Error(`${beside.run} is a run of split ${keyOfRun(beside) ?? 'unknown'}, and ${shown.run} of ${keyOfRun(shown) ?? 'unknown'}.`);
    }
    return [shown, beside];
  };
  main.classList.add('wide', 'replay'); // from the beginning: what is there does not move
  const [shown, beside] = await read().catch((error: unknown) => {
    main.classList.remove('wide', 'replay');
    main.append(above);
    throw error;
  });
  document.title = `${episode} of ${shown.run} · Enfilade`;
  const panels = [shown, ...(beside ? [beside] : [])].map((one) => new RunPanel(one));
  const page = new EpisodePage(panels);
  const picker = await compareControl(shown, other);
  main.replaceChildren(
    make('div', { class: 'replay-head' }, above, make('h1', {}, `Episode ${episode}`),
      ...page.controls(...(picker ? [picker] : []), ...linksOf(shown, other), ...page.filmControl())),
    make('div', { class: panels.length > 1 ? 'replay-runs two' : 'replay-runs' }, ...panels.map(({ element }) => element)));
  await page.open();
  window.replay = { get step() { return page.step; }, get viewers() { return panels.map(({ viewer }) => viewer); } };
}
