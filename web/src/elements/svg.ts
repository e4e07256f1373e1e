/** Elements of SVG. */

const namespace = 'http://www.w3.org/2000/svg';

/** An SVG element. Its attributes are ours alone, never what people wrote. */
export function shape<K extends keyof SVGElementTagNameMap>(
  name: K, attributes: Readonly<Record<string, string | number>>, ...children: (Element | string)[]
): SVGElementTagNameMap[K] {
  const element = document.createElementNS(namespace, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
  element.append(...children);
  return element;
}
