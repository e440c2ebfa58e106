declare module 'virtual:worker' {
  /** The script of a worker. */
  const text: string;
  export default text;
}
