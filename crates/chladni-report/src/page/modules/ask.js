// Questions to the studio's server.

/** The token in the address of this page, which goes with every question. */
const headers = { "Content-Type": "application/json", Authorization: `Bearer ${new URLSearchParams(location.search).get("token")}` };

async function post(path, question, signal) {
  return fetch(`/api/${path}`, { method: "POST", headers, body: JSON.stringify(question), signal });
}

/** The answer to a question; failures are `{error}`. */
export async function answerTo(path, question = {}, signal) {
  try {
    const response = await post(path, question, signal);
    return response.ok ? await response.json() : { error: await response.text() };
  } catch {
    return signal?.aborted ? { cancelled: true } : { error: "the studio does not answer: was it ended?" };
  }
}

/** The bytes of a file of the studio; throws an error with words for the reader. */
export async function fileOf(question) {
  const response = await post("file", question);
  if (!response.ok) throw new Error(await response.text());
  return response.blob();
}

/** Asks questions of one kind, one at a time. Of the waiting questions only the last is asked. */
export class Asker {
  constructor(path) {
    this.path = path;
    this.running = false;
    this.next = null;
    this.stop = null;
  }

  /** `answer` gets the answer of the server, and true where a newer question waits. */
  ask(question, answer) {
    this.next = { question, answer };
    if (!this.running) this.run();
  }

  /** Ignores the answers that are still to come. */
  cancel() {
    this.next = null;
    this.stop?.abort();
  }

  async run() {
    this.running = true;
    while (this.next) {
      const { question, answer } = this.next;
      this.next = null;
      this.stop = new AbortController();
      answer(await answerTo(this.path, question, this.stop.signal), this.next !== null);
    }
    this.running = false;
  }
}
