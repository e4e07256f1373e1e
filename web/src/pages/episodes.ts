/** The instructions of a split, with filters: `/episodes?split=S&q=words&offset=N`. */
import { addSiteHeader, api, byId, make, problems, run, table } from '../page.ts';
import { forgetResults, keepResults, keptResults, parseResults, type Results } from '../results.ts';
import type { Episode } from '../scan.ts';

interface SplitList {
  readonly splits: readonly { split: string; instructions: number; goals_hidden: boolean }[];
}
interface EpisodeList {
  readonly matching: number;
  readonly episodes: readonly Episode[];
}

const perPage = 50;

/** Choosing a results file, whose walks the viewer then shows beside the reference paths. */
function resultsControl(split: () => string, changed: () => void): { box: HTMLElement; forget: HTMLElement } {
  const file = make('input', { id: 'results', type: 'file', accept: '.json,application/json' });
  const forget = make('button', { type: 'button' }, 'Forget it');
  const said = make('div', { 'aria-live': 'polite' });
  const keep = async (): Promise<void> => {
    const text = await file.files![0]!.text();
    const { size } = parseResults(text);
    await keepResults(split(), text);
    said.replaceChildren(make('p', { class: 'done' }, `${size} walks, kept in this browser. Open an episode to see one.`));
    changed();
  };
  file.addEventListener('change', () => {
    keep().catch((error: unknown) => said.replaceChildren(problems(error)));
  });
  forget.addEventListener('click', () => {
    file.value = '';
    said.replaceChildren();
    void forgetResults(split()).then(changed);
  });
  const box = make('div', {}, make('label', { for: 'results' }, 'Results file of this split, to look at (it stays in this browser)'),
    file, ' ', forget, said);
  return { box, forget };
}

function rowOf(split: string, episode: Episode, results: Results | undefined): (Node | string)[] {
  const href = `/view?split=${encodeURIComponent(split)}&id=${encodeURIComponent(episode.instruction_id)}`;
  return [
    make('a', { href }, episode.instruction_id),
    episode.instruction,
    ...(results ? [make('td', { class: 'number' }, String(results.get(episode.instruction_id)?.viewpoints.length ?? 'none'))] : []),
    make('td', { class: 'number' }, episode.distance === undefined ? 'hidden' : `${episode.distance} m`),
    episode.scan,
  ];
}

run(async () => {
  await addSiteHeader();
  const { splits } = await api.call<SplitList>('splits');
  const main = byId('main');
  main.append(make('h1', {}, 'Episodes'));
  if (splits.length === 0) {
    main.append(make('p', {}, 'This data set has no annotations.'));
    return;
  }
  const split = make('select', { id: 'split' }, ...splits.map((s) =>
    new Option(`${s.split} (${s.instructions}${s.goals_hidden ? ', goals hidden' : ''})`, s.split)));
  const words = make('input', { id: 'words', type: 'search' });
  const list = make('div', { 'aria-live': 'polite' });
  let offset = 0;
  const show = async (): Promise<void> => {
    const query = new URLSearchParams({ q: words.value, offset: String(offset), limit: String(perPage) });
    const found = await api.call<EpisodeList>(`splits/${encodeURIComponent(split.value)}/episodes?${query}`);
    const results = await keptResults(split.value);
    chosen.forget.hidden = results === undefined;
    const last = Math.min(offset + perPage, found.matching);
    const turn = (text: string, to: number, possible: boolean) => {
      const button = make('button', { type: 'button' }, text);
      button.disabled = !possible;
      button.addEventListener('click', () => { offset = to; refresh(); });
      return button;
    };
    list.replaceChildren(
      table(['Id', 'Instruction', ...(results ? ['Walked viewpoints'] : []), 'Length', 'Building'],
        found.episodes.map((e) => rowOf(split.value, e, results))),
      make('p', { class: 'pages' }, turn('Before', offset - perPage, offset > 0),
        `${found.matching === 0 ? 0 : offset + 1} to ${last} of ${found.matching}`,
        turn('After', offset + perPage, last < found.matching)),
    );
  };
  const refresh = () => { show().catch((error: unknown) => list.replaceChildren(problems(error))); };
  const anew = () => { offset = 0; refresh(); };
  const chosen = resultsControl(() => split.value, anew);
  split.addEventListener('change', anew);
  words.addEventListener('input', anew);
  main.append(make('label', { for: 'split' }, 'Split'), split,
    make('label', { for: 'words' }, 'Words in the instruction'), words,
    chosen.box, list);
  await show();
});
