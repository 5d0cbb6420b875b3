// The page of all examples.
import { openPage } from "../lib/page.js";

openPage();
