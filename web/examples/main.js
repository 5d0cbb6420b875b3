// The page of all examples.
import { openPage } from "../lib/page.js";
import words from "../messages/examples.js";

openPage({ examples: words });
