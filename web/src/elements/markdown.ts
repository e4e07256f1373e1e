/**
 * Markdown that organisers write, as a tree of a few elements. HTML in it stays text, so there is
 * nothing to clean: only what stands in this file can come out.
 */
import { lexer, type Token, type Tokens } from 'marked';

type Name =
  | 'a' | 'blockquote' | 'br' | 'code' | 'del' | 'em' | 'h2' | 'h3' | 'h4' | 'hr' | 'li' | 'ol' | 'p'
  | 'pre' | 'strong' | 'table' | 'tbody' | 'td' | 'th' | 'thead' | 'tr' | 'ul';

/** A text, or an element with its parts. */
export type Part =
  | string
  | { readonly name: Name; readonly attributes: Record<string, string>; readonly parts: readonly Part[] };

const element = (name: Name, parts: readonly Part[], attributes: Record<string, string> = {}): Part =>
  ({ name, attributes, parts });

const named: Record<string, string> = {
  amp: '&', lt: '<', gt: '>', quot: '"', apos: "'", nbsp: '\u00a0', ndash: '–', mdash: '—', hellip: '…',
};

/** Character references; the rarer names stay as they are. */
const decode = (text: string): string =>
  text.replace(/&(?:#(\d{1,7})|#x([\da-f]{1,6})|([a-z]+));/gi, (all, decimal, hex, name) => {
    if (name) return named[name as string] ?? (all as string);
    const point = decimal ? Number(decimal) : Number.parseInt(hex as string, 16);
    return point > 0 && point <= 0x10ffff ? String.fromCodePoint(point) : '\ufffd';
  });

/** A link's address, if it is one that can do no harm: no javascript:, no data:. */
function harmless(href: string): string | undefined {
  const scheme = /^[^/?#]*?:/.exec(decode(href).replace(/[\u0000-\u0020]/g, ''))?.[0].toLowerCase();
  if (scheme === undefined) return href;
  return ['http:', 'https:', 'mailto:'].includes(scheme) ? href : undefined;
}

function link(token: Tokens.Link): readonly Part[] {
  const parts = inline(token.tokens);
  const href = harmless(token.href);
  if (href === undefined) return parts;
  return [element('a', parts, { href, target: '_blank', rel: 'noopener noreferrer' })];
}

const inline = (tokens: readonly Token[] = []): Part[] => tokens.flatMap(parts);

function table({ header, rows }: Tokens.Table): Part {
  const row = (cells: readonly Tokens.TableCell[], name: 'th' | 'td') =>
    element('tr', cells.map((cell) => element(name, inline(cell.tokens))));
  return element('table', [
    element('thead', [row(header, 'th')]),
    element('tbody', rows.map((cells) => row(cells, 'td'))),
  ]);
}

function list({ ordered, start, items }: Tokens.List): Part {
  const entries = items.map((item) => element('li', inline(item.tokens)));
  if (!ordered) return element('ul', entries);
  return element('ol', entries, typeof start === 'number' && start !== 1 ? { start: String(start) } : {});
}

/** The page has an h1 of its own, so headings go down by one; there are three levels. */
const heading = (depth: number): Name => (['h2', 'h3', 'h4'] as const)[Math.min(depth, 3) - 1]!;

function parts(token: Token): readonly Part[] {
  const inner = () => inline((token as Tokens.Generic).tokens);
  switch (token.type) {
    case 'space': case 'def': return [];
    case 'paragraph': return [element('p', inner())];
    case 'heading': return [element(heading((token as Tokens.Heading).depth), inner())];
    case 'list': return [list(token as Tokens.List)];
    case 'table': return [table(token as Tokens.Table)];
    case 'blockquote': return [element('blockquote', inner())];
    case 'code': return [element('pre', [element('code', [(token as Tokens.Code).text])])];
    case 'hr': return [element('hr', [])];
    case 'br': return [element('br', [])];
    case 'strong': case 'em': case 'del': return [element(token.type, inner())];
    case 'codespan': return [element('code', [(token as Tokens.Codespan).text])];
    case 'link': return link(token as Tokens.Link);
    case 'escape': return [(token as Tokens.Escape).text];
    case 'text': return (token as Tokens.Text).tokens ? inner() : [decode((token as Tokens.Text).text)];
    case 'image': return [(token as Tokens.Image).text]; // its words; our pages load nothing from elsewhere
    default: return [token.raw]; // HTML, and whatever a later parser knows
  }
}

export const parseMarkdown = (text: string): readonly Part[] => lexer(text).flatMap(parts);

function nodeOf(part: Part): Node {
  if (typeof part === 'string') return document.createTextNode(part);
  const node = document.createElement(part.name);
  for (const [key, value] of Object.entries(part.attributes)) node.setAttribute(key, value);
  node.append(...part.parts.map(nodeOf));
  return node;
}

/** For a page. */
export function markdown(text: string): HTMLElement {
  const box = document.createElement('div');
  box.className = 'prose';
  box.append(...parseMarkdown(text).map(nodeOf));
  return box;
}
