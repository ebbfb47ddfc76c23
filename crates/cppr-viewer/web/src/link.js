// Links that carry a robot and its state: behind the #, which no server gets to see, packed and in the letters of base 64.

const through = async (bytes, stream) => new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());

/** The address of this page with a robot file and a scenario. */
export async function link(file, scenario) {
  const packed = await through(new TextEncoder().encode(JSON.stringify({ file, scenario })), new CompressionStream("deflate-raw"));
  const text = btoa(String.fromCharCode(...packed)).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
  return `${location.href.split("#")[0]}#${text}`;
}

/** What the address asks for: file and scenario, null where it asks for nothing or for what cannot be read. */
export async function beginsWith(hash) {
  if (hash.length < 2) return { file: null, scenario: null };
  try {
    const packed = Uint8Array.from(atob(hash.slice(1).replaceAll("-", "+").replaceAll("_", "/")), (c) => c.charCodeAt(0));
    const { file, scenario } = JSON.parse(new TextDecoder().decode(await through(packed, new DecompressionStream("deflate-raw"))));
    if (typeof file?.text !== "string" || typeof scenario !== "object") throw new TypeError("it carries no robot");
    return { file: { name: String(file.name), text: file.text }, scenario };
  } catch {
    return { file: null, scenario: null, problem: "It is cut or changed: copy it again, whole. A robot that comes with the page is shown instead." };
  }
}
