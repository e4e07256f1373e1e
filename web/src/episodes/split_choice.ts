/** Choosing a split: the benchmark, then one of its splits. */
import { labelled } from '../elements/forms.ts';
import { make } from '../elements/page.ts';
import { type Offered, parseKey } from './splits.ts';

export class SplitChoice {
  /** Two labelled selects, for a form. */
  readonly boxes: readonly HTMLElement[];
  private readonly offered: readonly Offered[];
  private readonly benchmark: HTMLSelectElement;
  private readonly split = make('select');

  /** @param offered one at least  @param changed a person chose another split, by its key */
  constructor(offered: readonly Offered[], changed: (key: string) => void = () => {}) {
    this.offered = offered;
    const benchmarks = offered.map(({ task, title }) => new Option(title, task));
    const [benchmarkBox, benchmark] = labelled('benchmark', 'Benchmark', make('select', {}, ...benchmarks));
    const [splitBox] = labelled('split', 'Split', this.split);
    this.benchmark = benchmark;
    this.boxes = [benchmarkBox, splitBox];
    this.value = offered[0]!.splits[0]!.key;
    benchmark.addEventListener('change', () => {
      const name = parseKey(this.value).split; // the same one of the other benchmark, where it has it
      const { splits } = this.offered.find(({ task }) => task === benchmark.value)!;
      this.value = (splits.find(({ split }) => split === name) ?? splits[0]!).key;
      changed(this.value);
    });
    this.split.addEventListener('change', () => changed(this.value));
  }

  /** The key of the split. */
  get value(): string {
    return this.split.value;
  }

  /** Keys that are not offered change nothing. */
  set value(key: string) {
    const of = this.offered.find(({ splits }) => splits.some((one) => one.key === key));
    if (!of) return;
    this.benchmark.value = of.task;
    if (![...this.split.options].some(({ value }) => value === key)) {
      this.split.replaceChildren(...of.splits.map(({ key: value, text }) => new Option(text, value)));
    }
    this.split.value = key;
  }
}
