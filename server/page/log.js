// The end of the server's log.

const kLines = 500;

export class Log {
  constructor(connection, element) {
    this.connection = connection;
    this.element = element;
    this.last = 0;
  }

  async update() {
    const {first = 0, lines} = await this.connection.log(this.last);
    if (lines.length === 0) {
      // A server that started again counts from one.
      if (first <= this.last && this.last > 0 && first !== this.last + 1) this.last = 0;
      return;
    }
    this.last = first + lines.length - 1;
    const atEnd = this.element.scrollTop + this.element.clientHeight >= this.element.scrollHeight - 4;
    const kept = [...this.element.textContent.split('\n').filter(line => line), ...lines].slice(-kLines);
    this.element.textContent = `${kept.join('\n')}\n`;
    if (atEnd) this.element.scrollTop = this.element.scrollHeight;
  }
}
