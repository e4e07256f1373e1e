/**
 * A person walks an episode as a language model does, by the same observations and tools:
 * `/play?task=r2r&split=val_unseen&episode=ID&view=text|marks`; without an episode one is chosen.
 */
import { action, form, labelled, twice } from '../elements/forms.ts';
import { addSiteHeader, byId, empty, facts, make, run } from '../elements/page.ts';
import { episodesOf, parseKey, type Split, splitKey, splitTitle } from '../episodes/splits.ts';
import { callOfKey, PlayedSession, type Wanted } from '../replay/plays.ts';
import { endText, type Observation, placeText, type ToolUse, turnText } from '../replay/runs.ts';
import { api } from '../server/api.ts';
import './play.css';

type View = 'text' | 'marks';

/** Its answer no tool can give. */
const unplayable = ['soon'];
const pictureSize = 384; // pixels: a quarter of the width

const address = ({ task, split, episode }: Wanted, view: View): string =>
  `/play?${new URLSearchParams({ task, split, episode, view })}`;

/** Any episode of a split. */
async function anyEpisode(key: string): Promise<string> {
  const ask = (offset: number) => api.call<{ matching: number; episodes: { instruction_id: string }[] }>(episodesOf(key, { limit: '1', offset: String(offset) }));
  const { matching } = await ask(0);
  const [episode] = (await ask(Math.floor(Math.random() * matching))).episodes;
  if (!episode) throw new Error('This split has no episode.');
  return episode.instruction_id;
}

async function startPage(main: HTMLElement): Promise<void> {
  const { splits } = await api.call<{ splits: Split[] }>('splits?task=all');
  const playable = splits.filter(({ task, instructions }) => instructions > 0 && !unplayable.includes(task));
  main.append(make('div', { class: 'page-head' }, make('h1', {}, 'Walk as a model does'),
    make('p', { class: 'lead' }, 'You get what a language model gets at each step, and have the tools that it has.')));
  if (playable.length === 0) {
    main.append(empty('No episodes', 'This data set has no episode that can be walked.', make('a', { href: '/', class: 'button' }, 'Buildings')));
    return;
  }
  const [splitBox, split] = labelled('split', 'Split', make('select', {}, ...playable.map((one) => new Option(splitTitle(one), splitKey(one)))));
  const [episodeBox, episode] = labelled('episode', 'Episode', make('input', { type: 'text', autocomplete: 'off', spellcheck: 'false' }), 'Its id, as 12_0; any one if you leave this empty.');
  const [viewBox, view] = labelled('view', 'What you get', make('select', {}, new Option('text only', 'text'), new Option('text, and a picture with the places marked', 'marks')));
  const query = new URLSearchParams(location.search);
  const asked = splitKey({ task: query.get('task') ?? 'r2r', split: query.get('split') ?? '' });
  if (playable.some((one) => splitKey(one) === asked)) split.value = asked;
  if (query.get('view') === 'marks') view.value = 'marks';
  main.append(form('Begin', [splitBox, episodeBox, viewBox], async () => {
    const wanted = { ...parseKey(split.value), episode: episode.value.trim() || await anyEpisode(split.value) };
    location.assign(address(wanted, view.value as View));
  }));
}

const toolTexts: Record<string, string> = {
  back_to: 'Go back to', look: 'Look', move: 'Move', answer: 'This is what was meant; it ends the episode',
};

class PlayPage {
  private readonly wanted: Wanted;
  private readonly view: View;
  private readonly session: PlayedSession;
  private readonly told = make('p', { role: 'status', class: 'play-told', tabindex: '-1' });
  private readonly picture = make('img', { class: 'play-picture', alt: '' });
  private readonly strip = make('div', { class: 'play-strip', tabindex: '0', role: 'region', 'aria-label': 'What is seen all around' }, this.picture);
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
    this.strip.hidden = true;
    const other = view === 'marks' ? 'text' : 'marks';
    main.append(
      make('div', { class: 'page-head' }, make('h1', {}, 'Follow the instruction'), make('p', { class: 'instruction' }, session.state.observation.instruction ?? '')),
      this.told, this.strip, this.body, this.said,
      this.foot);
    this.foot.append(make('label', { class: 'row' }, this.keys, 'Keys'),
        make('span', {}, 'A letter goes to its place, the arrow keys look around.'),
        make('a', { href: address(wanted, other) }, other === 'marks' ? 'With pictures' : 'Text only'), make('a', { href: '/play' }, 'Another episode'));
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
    URL.revokeObjectURL(this.picture.src);
    this.strip.hidden = !strip;
    if (!strip) return;
    this.picture.src = URL.createObjectURL(strip);
    this.picture.alt = `Left, ahead, right and behind of you, with the places ${places.map(({ name }) => name).join(', ')} marked`;
    await this.picture.decode().catch(() => {}); // what cannot be drawn stays away
  }

  private where({ here, step, heading }: Observation): HTMLElement {
    const { mistakes } = this.session.state;
    return facts([...(here ? [['You are at', here] as const] : []), ['You look towards', `${Math.round(heading)}°`], ['Steps', String(step)], ['Mistakes', String(mistakes)]]);
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
      ...(place.length > 0 ? [make('h2', {}, 'Places that you can go to'), make('ul', { class: 'play-places' }, ...place)] : []),
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
    void this.call(...call);
  }

  private async showEnd(): Promise<void> {
    URL.revokeObjectURL(this.picture.src);
    this.strip.hidden = this.foot.hidden = true;
    const { observation, mistakes, ending } = this.session.state;
    const { task, split, episode } = this.wanted;
    const heading = make('h2', { tabindex: '-1' }, 'The episode is over');
    const again = make('button', { type: 'button' }, 'Walk it again');
    again.addEventListener('click', () => {
      PlayedSession.forget(this.wanted);
      location.reload();
    });
    this.body.replaceChildren(heading, make('p', {}, `You ${endText({ ending: ending!, steps: observation.step, mistakes })}.`));
    const result = new Blob([await this.session.result()], { type: 'application/json' });
    this.body.append(make('p', { class: 'buttons' },
      make('a', { class: 'button main', href: URL.createObjectURL(result), download: `${episode.replace(/[^\w.-]/g, '_')}_result.json` }, 'Save the result'),
      again, make('a', { class: 'button', href: `/play?${new URLSearchParams({ task, split, view: this.view })}` }, 'Another episode'),
      ...(await this.goalIsOpen() ? [make('a', { class: 'button', href: `/view?${new URLSearchParams({ split: splitKey({ task, split }), id: episode })}` }, 'See the path')] : [])),
    make('p', { class: 'note' }, 'The result is an entry of a results file: enfilade score takes it.'));
    heading.focus();
  }

  /** Whether everybody may see where the episode ends. */
  private async goalIsOpen(): Promise<boolean> {
    const { splits } = await api.call<{ splits: Split[] }>('splits?task=all');
    return splits.some(({ task, split, goals_hidden }) => task === this.wanted.task && split === this.wanted.split && !goals_hidden);
  }
}

run(async () => {
  const main = byId('main');
  await addSiteHeader();
  const query = new URLSearchParams(location.search);
  const [split, episode] = [query.get('split'), query.get('episode')];
  if (!split || !episode) return startPage(main);
  const wanted = { task: query.get('task') ?? 'r2r', split, episode };
  const view = query.get('view') === 'marks' ? 'marks' : 'text';
  main.classList.add('play');
  const page = new PlayPage(main, wanted, view, await PlayedSession.open(api, wanted));
  await page.show();
}, 'This episode cannot be walked');
