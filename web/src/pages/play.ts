/**
 * A person plays an episode with a language model's observations and tools:
 * `/play?task=r2r&split=val_unseen&episode=ID&view=text|marks`. Without an episode the server chooses one; without a split there is a form.
 */
import { action, form, labelled, twice } from '../elements/forms.ts';
import { addSiteHeader, byId, empty, facts, make, problems, run } from '../elements/page.ts';
import { shownText } from '../episodes/episode.ts';
import { SplitChoice } from '../episodes/split_choice.ts';
import { episodePage, isPlayable, offeredBenchmarks, parseKey, type SplitList, splitKey } from '../episodes/splits.ts';
import { degrees } from '../geometry/geometry.ts';
import { callOfKey, PlayedSession, type SessionOutcome, type Wanted } from '../replay/plays.ts';
import { endText, type Observation, placeText, type ToolUse, turnText } from '../replay/runs.ts';
import { api, ServerError } from '../server/api.ts';
import './play.css';

type View = 'text' | 'marks';

const pictureSize = 384; // pixels: a quarter of the width

/** Without an episode: of any. */
const address = ({ task, split, episode }: Omit<Wanted, 'episode'> & Partial<Wanted>, view: View): string =>
  `/play?${new URLSearchParams({ task, split, ...(episode && { episode }), view })}`;

const viewOf = (query: URLSearchParams): View => (query.get('view') === 'marks' ? 'marks' : 'text');

async function startPage(main: HTMLElement): Promise<void> {
  const { splits } = await api.call<SplitList>('splits?task=all');
  const playable = offeredBenchmarks({ splits: splits.filter(({ task }) => isPlayable(task)), continuous: [] });
  main.append(make('div', { class: 'page-head' }, make('h1', {}, 'Play an episode'),
    make('p', { class: 'lead' }, 'You get the observations of a language model at each step, and act with its tools.')));
  if (playable.length === 0) {
    main.append(empty('No episodes', 'This data set has no episode that can be played.', make('a', { href: '/', class: 'button' }, 'Buildings')));
    return;
  }
  const split = new SplitChoice(playable);
  const [episodeBox, episode] = labelled('episode', 'Episode', make('input', { type: 'text', autocomplete: 'off', spellcheck: 'false' }),
    'Its id, as 12_0. Leave this empty for any one.');
  const [viewBox, view] = labelled('view', 'Observations', make('select', {}, new Option('text only', 'text'),
    new Option('text, and a picture with the viewpoints marked', 'marks')));
  const query = new URLSearchParams(location.search);
  const asked = playable.find(({ task }) => task === query.get('task'));
  if (asked) split.value = asked.splits[0]!.key;
  episode.value = query.get('episode') ?? '';
  view.value = viewOf(query);
  main.append(form('Begin', [...split.boxes, episodeBox, viewBox], async () => {
    location.assign(address({ ...parseKey(split.value), episode: episode.value.trim() }, view.value as View));
  }));
}

const toolTexts: Record<string, string> = {
  back_to: 'Go back to', look: 'Look', move: 'Move', answer: 'Name the object; this ends the episode',
};

const over = (): HTMLElement => make('h2', { tabindex: '-1' }, 'The episode is over');

class PlayPage {
  private readonly wanted: Wanted;
  private readonly view: View;
  private readonly session: PlayedSession;
  private readonly told = make('p', { role: 'status', class: 'play-told', tabindex: '-1' });
  /** The four views are one picture. Each half shows two of them, so that a phone can have them as 2 x 2. */
  private readonly halves = [make('img', { alt: '' }), make('img', { alt: '' })];
  private readonly strip = make('div', { class: 'play-strip', role: 'img', 'aria-label': 'The views are being drawn' },
    ...this.halves.map((half) => make('div', {}, half)));
  private picture = '';
  private readonly body = make('div', { class: 'play-body' });
  private readonly said = make('div');
  private readonly foot = make('p', { class: 'note play-foot' });
  private readonly keys = make('input', { type: 'checkbox' });
  private busy = false;

  constructor(main: HTMLElement, wanted: Wanted, view: View, session: PlayedSession) {
    this.wanted = wanted;
    this.view = view;
    this.session = session;
    this.keys.checked = true;
    this.strip.hidden = view !== 'marks'; // its room is there before the picture
    const other = view === 'marks' ? 'text' : 'marks';
    main.append(
      make('div', { class: 'page-head' }, make('h1', {}, 'Follow the instruction'),
        make('p', { class: 'instruction' }, shownText(session.state.observation.instruction ?? '', wanted.task))),
      this.told, this.strip, this.body, this.said,
      this.foot);
    this.foot.append(make('label', { class: 'row keys' }, this.keys, 'Keys'),
      make('span', { class: 'keys' }, 'A letter goes to its viewpoint, the arrow keys turn.'),
      make('a', { href: address(wanted, other) }, other === 'marks' ? 'With pictures' : 'Text only'),
      make('a', { href: '/play' }, 'Another episode'));
    addEventListener('keydown', (event) => this.key(event));
  }

  /** Shows the state. The picture comes after the words. */
  async show(): Promise<void> {
    const { observation, ending } = this.session.state;
    this.told.textContent = observation.told || 'You are at the start.';
    if (ending) return this.showEnd();
    this.body.replaceChildren(this.where(observation), ...this.tools(observation));
    if (this.view === 'marks') await this.draw(observation);
  }

  private async draw({ places = [] }: Observation): Promise<void> {
    const { calls } = this.session.state;
    const strip = await this.session.strip(pictureSize);
    if (calls !== this.session.state.calls) return; // gone on meanwhile
    URL.revokeObjectURL(this.picture);
    this.strip.hidden = !strip;
    if (!strip) return;
    this.picture = URL.createObjectURL(strip);
    const names = places.map(({ name }) => name).join(', ');
    this.strip.setAttribute('aria-label', `Left, ahead, right and behind of you, with the viewpoints ${names} marked`);
    for (const half of this.halves) half.src = this.picture;
    await Promise.all(this.halves.map((half) => half.decode())).catch(() => {}); // what cannot be drawn stays away
  }

  private where({ here, step, heading }: Observation): HTMLElement {
    const { mistakes } = this.session.state;
    return facts([...(here ? [['You are at', here] as const] : []), ['Heading', `${Math.round(heading)}°`], ['Steps', String(step)],
      ['Mistakes', String(mistakes)]]);
  }

  private tools(seen: Observation): HTMLElement[] {
    const { places = [], things = [], map = [], tools } = seen;
    const button = (text: string, tool: string, value: string, label = text) =>
      action(text, this.said, () => this.call(tool, value), { 'aria-label': label });
    const group = (use: ToolUse) => make('div', { class: 'play-tool', role: 'group', 'aria-label': toolTexts[use.tool] ?? use.tool },
      make('h2', {}, toolTexts[use.tool] ?? use.tool),
      make('div', { class: 'buttons' }, ...(use.allowed ?? []).map((value) => this.valueButton(use.tool, value, button, things))));
    const place = places.map((one) => make('li', {}, button(one.name, 'go_to', one.name, `Go to ${one.name}: ${placeText(one)}`),
      make('span', {}, placeText(one), one.what ? `; there: ${one.what}` : ''),
      ...(one.visited ? [make('span', { class: 'badge' }, 'visited')] : one.seen_before ? [make('span', { class: 'badge' }, 'seen before')] : [])));
    const [stop, turnBack] = ['stop', 'turn_back'].map((name) => tools.some(({ tool }) => tool === name));
    return [
      ...(place.length > 0 ? [make('h2', {}, 'Viewpoints that you can go to'), make('ul', { class: 'play-places' }, ...place)] : []),
      ...tools.filter(({ tool, allowed }) => tool !== 'go_to' && tool !== 'stop' && allowed).map(group),
      ...(map.length > 1 ? [make('details', {}, make('summary', {}, 'The map so far'), make('ul', {}, ...map.map(({ name, leads_to }) =>
        make('li', {}, make('b', {}, name), ` leads to ${leads_to.join(', ')}`))))] : []),
      ...(turnBack ? [make('p', {}, button('The way back begins here', 'turn_back', ''))] : []),
      ...(stop ? [make('p', {}, twice('Stop here', 'Stop for good?', this.said, () => this.call('stop', '')))] : [])];
  }

  private valueButton(tool: string, value: string, button: (text: string, tool: string, value: string, label?: string) => HTMLButtonElement, things: Observation['things']): HTMLButtonElement {
    if (tool !== 'answer') return button(value, tool, value, `${toolTexts[tool] ?? tool} ${value}`);
    const thing = things?.find(({ name }) => name === value);
    return twice(thing ? `${value}: ${thing.category}, ${turnText(thing.turn)}` : value, `Name ${value} and stop?`, this.said, () => this.call('answer', value));
  }

  private async call(tool: string, value: string): Promise<void> {
    if (this.busy) return; // a key that repeats calls once
    this.busy = true;
    const inside = this.body.contains(document.activeElement); // on what is about to go
    try {
      await this.session.call(tool, value);
    } finally {
      this.busy = false;
      const shown = this.show();
      if (inside) this.told.focus();
      await shown;
    }
  }

  private key(event: KeyboardEvent): void {
    const { observation, ending } = this.session.state;
    if (!this.keys.checked || ending || event.ctrlKey || event.metaKey || event.altKey || event.repeat) return;
    if ((event.target as HTMLElement).closest('input:not([type=checkbox]), select, textarea')) return;
    const call = callOfKey(event.key, observation);
    if (!call) return;
    event.preventDefault();
    this.call(...call).catch((error: unknown) => this.said.replaceChildren(problems(error)));
  }

  private async showEnd(): Promise<void> {
    URL.revokeObjectURL(this.picture);
    this.strip.hidden = this.foot.hidden = true;
    const { observation, mistakes, ending } = this.session.state;
    const { task, split, episode } = this.wanted;
    const again = make('button', { type: 'button' }, 'Play it again');
    again.addEventListener('click', () => {
      PlayedSession.forget(this.wanted);
      location.reload();
    });
    const [outcome, json] = await Promise.all([this.session.outcome(), this.session.result()]);
    const result = new Blob([json], { type: 'application/json' });
    const link = (href: string, text: string) => make('a', { class: 'button', href }, text);
    const verdict = await this.verdict(outcome).catch((error: unknown) => [over(), problems(error)]); // the result can be saved all the same
    this.body.replaceChildren(...verdict,
      make('p', {}, `You ${endText({ ending: ending!, steps: observation.step, mistakes })}.`),
      make('p', { class: 'buttons' },
        make('a', {
          class: 'button main', href: URL.createObjectURL(result), download: `${episode.replace(/[^\w.-]/g, '_')}_result.json`,
        }, 'Save the result'),
        again, link(address({ task, split }, this.view), 'Another episode'),
        ...(outcome ? [link(episodePage(splitKey({ task, split }), episode), 'Show the reference path')] : [])),
      make('p', { class: 'note' }, 'The result is an entry of a results file: enfilade score takes it.'));
    this.body.querySelector('h2')!.focus();
  }

  /** Distance, success and map, where everybody may see the goal. */
  private async verdict(outcome: SessionOutcome | undefined): Promise<HTMLElement[]> {
    if (!outcome) return [over()];
    const [{ outcomeHeading, outcomePart, stillAt }, scan] = await Promise.all([
      import('../episodes/outcome_part.ts'), api.scan(outcome.scan)]);
    const end = stillAt(scan, outcome.walk.at(-1)!, degrees(this.session.state.observation.heading));
    return [outcomeHeading(outcome), outcomePart(api, end, outcome)];
  }
}

/** The session of an address; nothing if the server has no such episode, which is then said with a way back. */
async function open(main: HTMLElement, wanted: Omit<Wanted, 'episode'> & Partial<Wanted>): Promise<PlayedSession | undefined> {
  try {
    return await PlayedSession.open(api, wanted);
  } catch (error) {
    if (!(error instanceof ServerError)) throw error;
    main.append(make('h1', {}, 'This episode cannot be played'), problems(error),
      make('p', { class: 'buttons' }, make('a', { class: 'button', href: '/play' }, 'Choose another episode')));
    return undefined;
  }
}

run(async () => {
  const main = byId('main');
  await addSiteHeader();
  const query = new URLSearchParams(location.search);
  const [split, episode] = [query.get('split'), query.get('episode')];
  if (!split) return startPage(main);
  const session = await open(main, { task: query.get('task') || 'r2r', split, ...(episode && { episode }) });
  if (!session) return;
  const view = viewOf(query);
  const { task, split: name, episode: id } = session.state;
  const wanted = { task, split: name, episode: id };
  history.replaceState(null, '', address(wanted, view)); // a reload has the same episode
  main.classList.add('play');
  await new PlayPage(main, wanted, view, session).show();
}, 'This episode cannot be played');
