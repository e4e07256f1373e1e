import { describe, expect, it } from 'vitest';
import { type Part, parseMarkdown } from './markdown.ts';

/** The tree as a browser would write it, texts escaped. */
const written = (part: Part): string => {
  if (typeof part === 'string') return part.replaceAll('&', '&amp;').replaceAll('<', '&lt;');
  const attributes = Object.entries(part.attributes).map(([key, value]) => ` ${key}="${value}"`).join('');
  return `<${part.name}${attributes}>${part.parts.map(written).join('')}</${part.name}>`;
};
const html = (text: string): string => parseMarkdown(text).map(written).join('');

describe('Markdown', () => {
  it('has what a page of consent needs', () => {
    expect(html('# Who we are\n\nWe *pay* **by the hour**, see `rules`.')).toBe(
      '<h2>Who we are</h2><p>We <em>pay</em> <strong>by the hour</strong>, see <code>rules</code>.</p>');
    expect(html('- one\n- two')).toBe('<ul><li>one</li><li>two</li></ul>');
    expect(html('3. three\n4. four')).toBe('<ol start="3"><li>three</li><li>four</li></ol>');
    expect(html('a  \nb\n\n---')).toBe('<p>a<br></br>b</p><hr></hr>');
    expect(html('> said')).toBe('<blockquote><p>said</p></blockquote>');
    expect(html('|a|b|\n|-|-|\n|1|2|')).toContain('<th>a</th>');
  });

  it('reads character references and escapes once', () => {
    expect(html('a &amp; b &lt;c&gt; &#65; \\*d\\*')).toBe('<p>a &amp; b &lt;c> A *d*</p>');
    expect(html('`a &amp; b`')).toBe('<p><code>a &amp;amp; b</code></p>');
    expect(html('&#0;&#x110000;&unknown;')).toBe('<p>\ufffd\ufffd&amp;unknown;</p>');
  });

  it('leaves HTML as the text that it is', () => {
    for (const text of ['<script>alert(1)</script>', 'a <img src=x onerror=alert(1)> b', '<div onclick="x">\n\n*b*\n\n</div>']) {
      expect(html(text)).not.toMatch(/<(script|img|div)/);
      expect(html(text)).toContain('&lt;');
    }
  });

  it('links to the web and to mail, and to nothing that runs', () => {
    expect(html('[a](https://example.org/x)')).toBe(
      '<p><a href="https://example.org/x" target="_blank" rel="noopener noreferrer">a</a></p>');
    expect(html('[a](mailto:x@example.org)')).toContain('href="mailto:');
    for (const href of ['javascript:alert(1)', 'JaVaScRiPt:alert(1)', 'data:text/html,x', 'vbscript:x',
      '&#106;avascript:alert(1)', 'java&#10;script:alert(1)', '<java\tscript:alert(1)>']) {
      expect(html(`[a](${href})`), href).not.toContain('<a');
    }
  });

  it('shows the words of a picture', () => {
    expect(html('![a plan](https://example.org/p.png)')).toBe('<p>a plan</p>');
  });
});
