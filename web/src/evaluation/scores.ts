/** Numbers of a leaderboard as cells: a value with its interval, drawn and written. */
import { intervalBar, scaleOf } from '../elements/charts.ts';
import { make } from '../elements/page.ts';
import { bestText, type Column, format, intervalOf, rangeText, type Row, unitOf, valueOf } from './ranking.ts';

type Scored = Pick<Row, 'means'>;

export const columnHead = (column: Column): HTMLElement =>
  make('th', { scope: 'col', class: 'number', title: column.title }, column.short, make('span', { class: 'unit' }, unitOf(column)));

/** The cells of a column. @param compared whose best value stands in bold, and whose intervals share a scale */
export function scoreCells(rows: readonly Scored[], column: Column, compared: readonly Scored[] = rows): HTMLElement[] {
  const best = bestText(compared, column);
  const scale = scaleOf(compared.flatMap((row) => intervalOf(row, column) ?? []));
  return rows.map((row) => {
    const text = format(valueOf(row, column), column);
    const isBest = text === best && compared.includes(row);
    const cell = make('td', { class: isBest ? 'number best' : 'number', 'data-label': `${column.short}, ${unitOf(column)}` }, text);
    const [interval, range] = [intervalOf(row, column), rangeText(row, column)];
    if (interval && range) {
      cell.append(intervalBar(interval, scale, `95 % interval ${range.replace('–', ' to ')}`),
        make('span', { class: 'range', 'aria-hidden': 'true' }, range));
    }
    return cell;
  });
}
