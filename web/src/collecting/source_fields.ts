/** Which paths a new collection is made of: splits of the data set, a file, or another collection's texts. */
import { jsonFiles, textOf } from '../elements/files.ts';
import { field, labelled } from '../elements/forms.ts';
import { counted, make } from '../elements/page.ts';
import type { Kind } from './collections.ts';
import { namePattern } from './text_fields.ts';

export interface SplitList {
  readonly splits: readonly { split: string; paths: number; instructions: number; goals_hidden: boolean }[];
}

interface SourceFields {
  readonly box: HTMLElement;
  /** Shows those that a kind needs. */
  show(kind: Kind): void;
  /** As the server takes them. Throws Error if nothing is chosen. */
  read(kind: Kind): Promise<object[]>;
}

export function sourceFields({ splits }: SplitList): SourceFields {
  const boxes = splits.map(({ split, paths, goals_hidden }) => {
    const tick = make('input', { type: 'checkbox', value: split });
    return { tick, label: make('label', { class: 'row' }, tick, `${split} (${counted(paths, 'path')}${goals_hidden ? ', goals hidden' : ''})`) };
  });
  const [fileBox, file] = field('paths', splits.length > 0 ? 'Also, or instead, a file of paths' : 'A file of paths',
    { type: 'file', accept: jsonFiles }, 'As enfilade sample writes, or any R2R file: path_id, scan, heading, path. ' +
    'Where objects are described or found, and for dialogues, also REVERIE files; for dialogues, CVDN files.');
  file.required = false;
  const [splitBox, split] = field('split', "That file's split, as the export will call it", { value: 'train', pattern: namePattern });
  const [mostBox, most] = field('most', 'Only the first paths of each', { type: 'number', min: '1', placeholder: 'all' });
  most.required = false;
  const [practiceBox, practice] = labelled('practice', 'Practice, for every worker first',
    make('select', {}, new Option('none', ''), ...splits.filter(({ goals_hidden }) => !goals_hidden)
      .map(({ split: name }) => new Option(`the first path of ${name}`, name))),
    'With feedback; it is never reviewed nor exported, and that path is no task.');
  const [objectsBox, objects] = field('objects', 'Objects at the end of each path', { type: 'number', min: '1', max: '20', value: '1' },
    'The largest ones that people would ask for: no wall, door frame or window, and only if the room has one of that name. ' +
    'A file may name them itself.');
  const [fromBox, from] = field('from', 'Descriptions of this collection', { maxlength: '40', pattern: namePattern },
    'The name, in links, of a collection of descriptions: what was accepted there is to be found here. Or a file of REVERIE.');
  from.required = false;
  const list = make('fieldset', {}, make('legend', {}, 'Paths of the data set'), ...boxes.map(({ label }) => make('div', {}, label)));
  const show = (kind: Kind): void => {
    practiceBox.hidden = boxes.length === 0 || kind === 'dialogue' || kind === 'find';
    objectsBox.hidden = kind !== 'describe' && kind !== 'dialogue';
    fromBox.hidden = kind !== 'find';
    list.hidden = boxes.length === 0 || kind === 'find';
  };
  const read = async (kind: Kind): Promise<object[]> => {
    const limit = { ...(most.value && { most: Number(most.value) }), ...(!objectsBox.hidden && { objects: Number(objects.value) }) };
    if (kind === 'find' && from.value) return [{ collection: from.value, ...(most.value && { most: Number(most.value) }) }];
    const first: object[] = practice.value && !practiceBox.hidden ? [{ split: practice.value, most: 1, practice: true }] : [];
    const chosen: object[] = (kind === 'find' ? [] : boxes.filter(({ tick }) => tick.checked)).map(({ tick }) => ({ split: tick.value, ...limit }));
    const [given] = file.files ?? [];
    if (given) chosen.push({ split: split.value, paths: JSON.parse(await textOf(given)) as object[], ...limit });
    if (chosen.length === 0) throw new Error('Choose paths: a split of the data set, or a file.');
    return [...first, ...chosen];
  };
  show('write');
  return { box: make('div', {}, fromBox, list, fileBox, splitBox, mostBox, objectsBox, practiceBox), show, read };
}
