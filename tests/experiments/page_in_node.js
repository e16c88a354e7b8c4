// Runs the script of a page of results without a browser, and prints what came of it: node page_in_node.js PAGE
const fs = require("fs");
const page = fs.readFileSync(process.argv[2], "utf8");
const data = page.match(/<script id="data" type="application\/json">([\s\S]*?)<\/script>/)[1];
const script = page.match(/<script>\n([\s\S]*?)<\/script>/)[1];
let drawn = 0, listed = 0;
const pen = new Proxy({}, { get: (_, name) => () => { if (name === "fillRect") drawn++; }, set: () => true });
const element = () => ({
  style: {}, width: 520, height: 400, value: "", textContent: "", append() {}, addEventListener() {},
  getContext: () => pen, appendChild() { listed++; return {}; }, insertRow: element,
});
const known = { data: { textContent: data } };
globalThis.document = {
  getElementById: name => (known[name] ??= element()),
  createElement: element,
};
new Function(script)();
console.log(JSON.stringify({ drawn, listed, words: known.count.textContent }));
