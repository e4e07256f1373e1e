// Two episodes by the protocol's client for TypeScript. It lists the tools once, as assistants do.
//
//   npm install --prefix FOLDER @modelcontextprotocol/sdk
//   ENFILADE_NODE_MODULES=FOLDER/node_modules node client.mjs COMMAND...    a server on standard input and output
//   ENFILADE_NODE_MODULES=FOLDER/node_modules node client.mjs http://...    one over HTTP
import assert from "node:assert";
import { createRequire } from "node:module";

const load = createRequire(process.env.ENFILADE_NODE_MODULES + "/client.js");
const { Client } = load("@modelcontextprotocol/sdk/client/index.js");
const { StdioClientTransport } = load("@modelcontextprotocol/sdk/client/stdio.js");
const { StreamableHTTPClientTransport } = load("@modelcontextprotocol/sdk/client/streamableHttp.js");

const [command, ...args] = process.argv.slice(2);
const transport = command.startsWith("http")
  ? new StreamableHTTPClientTransport(new URL(command))
  : new StdioClientTransport({ command, args });
const client = new Client({ name: "client.mjs", version: "1" });
await client.connect(transport);

const names = (await client.listTools()).tools.map((tool) => tool.name);
assert.deepStrictEqual(names, ["begin", "go_to", "back_to", "look", "stop"]);

async function call(name, given = {}) {
  assert(names.includes(name));
  const result = await client.callTool({ name, arguments: given });
  return result.content.map((block) => block.text ?? "").join("\n");
}

const said = await call("begin");
assert.match(said, /Instruction: /);
const place = said.match(/^go_to place: (\w+)/m)[1];
assert.match(await call("go_to", { place }), new RegExp(`You went to ${place}`));
assert.match(await call("back_to", { place: "A" }), /You went to A/);
assert.match(await call("go_to", { place: "QQ" }), /is not one of/);
assert.match(await call("stop"), /The episode is over/);
assert.match(await call("stop"), /begin starts the next one/);
assert.match(await call("begin"), /Instruction: /);
assert.match(await call("stop"), /The episode is over/);
await client.close();
